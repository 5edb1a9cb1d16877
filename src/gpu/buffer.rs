//! Memory on the device: creation within limits, upload, readback.

use super::Device;
use crate::error::{Error, Result};
use bytemuck::{AnyBitPattern, NoUninit, Zeroable};
use std::sync::{Arc, mpsc};

/// Largest piece copied between host and device at once, bytes: bounds the staging memory.
const PIECE: u64 = 64 << 20;

/// A buffer on the device, or a part of one. Cheap to clone.
///
/// Kernels see at least one element, also of a buffer without any: they take their counts from
/// parameters, never from `arrayLength`.
#[derive(Debug, Clone)]
pub struct Buffer {
    pub(super) raw: wgpu::Buffer,
    label: Arc<str>,
    offset: u64,
    bytes: u64,
}

impl Buffer {
    /// Label, for messages.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// Size in bytes (of this part).
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Number of elements of type `T`.
    pub fn len<T>(&self) -> usize {
        self.bytes as usize / size_of::<T>().max(1)
    }

    /// Whether it holds nothing.
    pub fn is_empty(&self) -> bool {
        self.bytes == 0
    }

    /// A part, counted in elements of `T`. To be bound, its offset must be a multiple of 256 bytes
    /// (every device's alignment divides that).
    ///
    /// # Errors
    /// If the part reaches beyond the buffer.
    pub fn part<T>(&self, first: usize, len: usize) -> Result<Self> {
        let size = size_of::<T>() as u64;
        let (offset, bytes) = (first as u64 * size, len as u64 * size);
        if offset + bytes > self.bytes {
            return Err(Error::new(format!(
                "elements {first}…{} lie outside the buffer '{}' of {} elements",
                first + len,
                self.label,
                self.bytes / size.max(1)
            )));
        }
        Ok(Self { offset: self.offset + offset, bytes, ..self.clone() })
    }

    pub(super) fn offset(&self) -> u64 {
        self.offset
    }

    /// What a kernel binds: at least 16 bytes, so that an empty buffer can be bound too.
    pub(super) fn binding(&self) -> wgpu::BufferBinding<'_> {
        let size = self.bytes.next_multiple_of(4).max(EMPTY_BYTES).min(self.raw.size() - self.offset);
        wgpu::BufferBinding { buffer: &self.raw, offset: self.offset, size: wgpu::BufferSize::new(size) }
    }
}

/// Room behind an empty buffer: as large as the largest array element in use.
const EMPTY_BYTES: u64 = 256;

/// Whether a value read from the device is a number.
pub(crate) trait Finite: AnyBitPattern {
    /// False for NaN and infinities, true for all integers.
    fn is_finite(&self) -> bool;
}

impl Finite for f32 {
    fn is_finite(&self) -> bool {
        f32::is_finite(*self)
    }
}

impl Finite for f64 {
    fn is_finite(&self) -> bool {
        f64::is_finite(*self)
    }
}

impl<T: Finite, const N: usize> Finite for [T; N]
where
    [T; N]: AnyBitPattern,
{
    fn is_finite(&self) -> bool {
        self.iter().all(Finite::is_finite)
    }
}

impl Device {
    fn create(&self, label: &str, bytes: u64, usage: wgpu::BufferUsages) -> Result<Buffer> {
        // Room beyond the end lets an empty buffer, or a part at the end, be bound.
        let size = bytes.next_multiple_of(4).max(EMPTY_BYTES);
        let limit = self.limits().max_buffer_size;
        if size > limit {
            return Err(Error::device(format!("the buffer '{label}' needs {bytes} bytes; '{}' allows {limit}", self.summary().name))
                .help("give a smaller --memory, so that the work is cut into smaller tiles"));
        }
        let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
        let raw = self.guarded(&format!("buffer '{label}' of {bytes} bytes"), || self.raw().create_buffer(&descriptor))?;
        Ok(Buffer { raw, label: label.into(), offset: 0, bytes })
    }

    /// A storage buffer holding these values.
    ///
    /// # Errors
    /// Too large for the device, or out of memory.
    pub(crate) fn upload<T: NoUninit>(&self, label: &str, values: &[T]) -> Result<Buffer> {
        let buffer = self.zeros::<T>(label, values.len())?;
        self.write(&buffer, values)?;
        Ok(buffer)
    }

    /// A storage buffer holding several tables, one after the other; each a multiple of four bytes long.
    ///
    /// # Errors
    /// Too large for the device, or out of memory.
    pub(crate) fn upload_tables(&self, label: &str, tables: &[&[u8]]) -> Result<Buffer> {
        let buffer = self.zeros::<u8>(label, tables.iter().map(|t| t.len()).sum())?;
        let mut at = 0;
        for table in tables {
            self.write(&buffer.part::<u8>(at, table.len())?, table)?;
            at += table.len();
        }
        Ok(buffer)
    }

    /// A storage buffer of `len` elements, all bytes zero.
    ///
    /// # Errors
    /// Too large for the device, or out of memory.
    pub fn zeros<T>(&self, label: &str, len: usize) -> Result<Buffer> {
        let bytes = (len as u64)
            .checked_mul(size_of::<T>() as u64)
            .ok_or_else(|| Error::new(format!("the size of the buffer '{label}' overflows")))?;
        self.create(label, bytes, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST)
    }

    /// A uniform buffer holding one value.
    ///
    /// # Errors
    /// Too large for the device, or out of memory.
    pub fn uniform<T: NoUninit>(&self, label: &str, value: &T) -> Result<Buffer> {
        let buffer = self.create(label, size_of::<T>() as u64, wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST)?;
        self.write(&buffer, std::slice::from_ref(value))?;
        Ok(buffer)
    }

    /// Overwrites the beginning of a buffer; takes effect before anything submitted later.
    ///
    /// # Errors
    /// More values than the buffer holds.
    pub fn write<T: NoUninit>(&self, buffer: &Buffer, values: &[T]) -> Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        if bytes.len() as u64 > buffer.bytes {
            return Err(Error::new(format!("{} bytes do not fit into the buffer '{}' of {}", bytes.len(), buffer.label, buffer.bytes)));
        }
        self.guarded(&format!("upload to '{}'", buffer.label), || {
            for (i, piece) in bytes.chunks(PIECE as usize).enumerate() {
                let offset = buffer.offset + i as u64 * PIECE;
                let whole = piece.len() & !3;
                self.queue().write_buffer(&buffer.raw, offset, &piece[..whole]);
                if whole < piece.len() {
                    // Copies go in units of four bytes; the room behind the buffer takes the rest.
                    let mut last = [0; 4];
                    last[..piece.len() - whole].copy_from_slice(&piece[whole..]);
                    self.queue().write_buffer(&buffer.raw, offset + whole as u64, &last);
                }
                if bytes.len() as u64 > PIECE {
                    // Lets the staging memory of this piece go before the next.
                    self.queue().submit([]);
                    let _ = self.raw().poll(wgpu::PollType::wait_indefinitely());
                }
            }
        })
    }

    /// Reads a buffer (or part) back, after everything submitted before.
    ///
    /// # Errors
    /// A failure of the device or of an earlier command, or out of memory.
    pub fn read<T: AnyBitPattern + NoUninit + Zeroable>(&self, buffer: &Buffer) -> Result<Vec<T>> {
        let mut values = vec![T::zeroed(); buffer.len::<T>()];
        self.read_into(buffer, &mut values)?;
        Ok(values)
    }

    /// Reads a buffer (or part) back into existing memory.
    ///
    /// # Errors
    /// As [`read`](Self::read), or a length that differs from the buffer's.
    pub(crate) fn read_into<T: AnyBitPattern + NoUninit>(&self, buffer: &Buffer, values: &mut [T]) -> Result<()> {
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(values);
        if bytes.len() as u64 != buffer.bytes {
            return Err(Error::new(format!(
                "{} bytes were to be read from the buffer '{}' of {}",
                bytes.len(),
                buffer.label,
                buffer.bytes
            )));
        }
        if bytes.is_empty() {
            return self.wait();
        }
        let what = format!("readback of '{}'", buffer.label);
        let staging = self.create(&what, buffer.bytes.min(PIECE), wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST)?;
        let failed = |e: &dyn std::fmt::Display| Error::device(format!("{what}: {e}"));
        for (i, piece) in bytes.chunks_mut(PIECE as usize).enumerate() {
            let size = (piece.len() as u64).next_multiple_of(4);
            self.guarded(&what, || {
                let mut encoder = self.raw().create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(&what) });
                encoder.copy_buffer_to_buffer(&buffer.raw, buffer.offset + i as u64 * PIECE, &staging.raw, 0, size);
                self.queue().submit([encoder.finish()]);
            })?;
            let (sender, receiver) = mpsc::channel();
            self.guarded(&what, || {
                staging.raw.map_async(wgpu::MapMode::Read, 0..size, move |result| {
                    let _ = sender.send(result);
                });
            })?;
            self.wait()?;
            receiver.recv().map_err(|e| failed(&e))?.map_err(|e| failed(&e))?;
            {
                let mapped = staging.raw.slice(0..size).get_mapped_range().map_err(|e| failed(&e))?;
                piece.copy_from_slice(&mapped[..piece.len()]);
            }
            staging.raw.unmap();
        }
        Ok(())
    }

    /// As [`read`](Self::read), and no NaN or infinity may be among the values.
    ///
    /// # Errors
    /// As [`read`](Self::read), or with the buffer's name, the number of bad values and the first.
    pub(crate) fn read_finite<T: Finite + NoUninit + Zeroable>(&self, buffer: &Buffer) -> Result<Vec<T>> {
        let values = self.read::<T>(buffer)?;
        check_finite(&values, buffer.label())?;
        Ok(values)
    }
}

/// Fails if a value is NaN or infinite.
pub(crate) fn check_finite<T: Finite>(values: &[T], label: &str) -> Result<()> {
    let Some(first) = values.iter().position(|v| !v.is_finite()) else {
        return Ok(());
    };
    let bad = values.iter().filter(|v| !v.is_finite()).count();
    Err(Error::new(format!("{bad} of {} values of '{label}' are not finite, the first at index {first}", values.len()))
        .help("look for infinite or extreme values in the input; if there are none, please report this"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back_as_they_went_whole_and_in_parts() {
        let Some(device) = Device::for_tests("buffers") else { return };
        let values: Vec<u32> = (0..1000).collect();
        let buffer = device.upload("values", &values).unwrap();
        assert_eq!(device.read::<u32>(&buffer).unwrap(), values);
        assert_eq!(device.read::<u32>(&buffer.part::<u32>(100, 3).unwrap()).unwrap(), [100, 101, 102]);
        device.write(&buffer.part::<u32>(1, 2).unwrap(), &[7u32, 8]).unwrap();
        assert_eq!(device.read::<u32>(&buffer).unwrap()[..4], [0, 7, 8, 3]);
        assert!(buffer.part::<u32>(999, 2).is_err() && device.write(&buffer, &[0u32; 1001]).is_err());
        let odd = device.upload("odd", &[1u8, 2, 3, 4, 5]).unwrap();
        assert_eq!(device.read::<u8>(&odd).unwrap(), [1, 2, 3, 4, 5]);
        let empty = device.upload::<f32>("empty", &[]).unwrap();
        assert!(device.read::<f32>(&empty).unwrap().is_empty());
    }

    #[test]
    fn several_pieces_are_joined() {
        let Some(device) = Device::for_tests("large buffers") else { return };
        let values: Vec<u32> = (0..(PIECE as u32 / 4) + 77).collect();
        let buffer = device.upload("large", &values).unwrap();
        assert!(device.read::<u32>(&buffer).unwrap() == values);
    }

    #[test]
    fn what_is_too_large_or_not_finite_is_an_error_that_names_the_buffer() {
        let Some(device) = Device::for_tests("buffer errors") else { return };
        let error = device.zeros::<f32>("huge", usize::MAX / 8).unwrap_err().to_string();
        assert!(error.contains("'huge'") && error.contains("--memory"), "{error}");
        assert!(device.zeros::<f64>("overflow", usize::MAX).is_err());
        let buffer = device.upload("poisoned", &[1.0f32, f32::NAN, f32::INFINITY]).unwrap();
        let error = device.read_finite::<f32>(&buffer).unwrap_err().to_string();
        assert!(error.contains("2 of 3") && error.contains("'poisoned'") && error.contains("index 1"), "{error}");
        assert_eq!(device.read::<f32>(&buffer).unwrap()[0], 1.0);
    }
}
