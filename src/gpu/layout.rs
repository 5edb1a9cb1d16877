//! Structs shared between Rust and WGSL, and the register of shader variants that tests check.

use std::borrow::Cow;

/// One member of a struct.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// Name, the same in Rust and WGSL.
    pub name: &'static str,
    /// Bytes from the start.
    pub offset: usize,
    /// Bytes.
    pub size: usize,
}

/// A struct whose layout a shader shares. Made by [`gpu_struct!`](crate::gpu_struct).
pub trait GpuStruct: bytemuck::Pod {
    /// Name, the same in Rust and WGSL.
    const NAME: &'static str;
    /// Members in order.
    const FIELDS: &'static [Field];
}

/// Layout of a [`GpuStruct`] as a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StructLayout {
    /// Name, the same in Rust and WGSL.
    pub name: &'static str,
    /// Size with trailing padding, bytes.
    pub size: usize,
    /// Members in order.
    pub fields: &'static [Field],
}

impl StructLayout {
    /// The layout of `T`.
    pub fn of<T: GpuStruct>() -> Self {
        Self { name: T::NAME, size: size_of::<T>(), fields: T::FIELDS }
    }

    /// Differences from the struct of that name in a naga module, one line each; empty if they agree.
    pub fn differences(&self, module: &naga::Module) -> Vec<String> {
        let Some((_, found)) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(self.name)) else {
            return vec![format!("WGSL has no struct '{}'", self.name)];
        };
        let naga::TypeInner::Struct { members, span } = &found.inner else {
            return vec![format!("'{}' is no struct in WGSL", self.name)];
        };
        let mut layouter = naga::proc::Layouter::default();
        if let Err(error) = layouter.update(module.to_ctx()) {
            return vec![error.to_string()];
        }
        let mut differences = Vec::new();
        if *span as usize != self.size {
            differences.push(format!("{}: {} bytes in Rust, {span} in WGSL", self.name, self.size));
        }
        if members.len() != self.fields.len() {
            differences.push(format!("{}: {} members in Rust, {} in WGSL", self.name, self.fields.len(), members.len()));
        }
        for (field, member) in self.fields.iter().zip(members) {
            let name = member.name.as_deref().unwrap_or("?");
            let (offset, size) = (member.offset as usize, layouter[member.ty].size as usize);
            if (field.name, field.offset, field.size) != (name, offset, size) {
                differences.push(format!(
                    "{}: '{}' at {} with {} bytes in Rust, '{name}' at {offset} with {size} bytes in WGSL",
                    self.name, field.name, field.offset, field.size
                ));
            }
        }
        differences
    }
}

/// A shader variant in use, with the structs it shares: what `tests/shaders.rs` links, validates
/// and compares.
#[derive(Debug, Clone)]
pub struct Registered {
    /// Path below `shaders/` without `.wgsl`.
    pub path: Cow<'static, str>,
    /// Features that are on.
    pub features: Vec<&'static str>,
    /// Texts only the host knows, by path.
    pub generated: Vec<(&'static str, String)>,
    /// Shared structs.
    pub structs: Vec<StructLayout>,
}

impl Registered {
    /// A variant without features.
    pub fn new(path: &'static str) -> Self {
        Self { path: path.into(), features: Vec::new(), generated: Vec::new(), structs: Vec::new() }
    }

    /// With these features on.
    #[must_use]
    pub fn features(mut self, features: &[&'static str]) -> Self {
        self.features.extend_from_slice(features);
        self
    }

    /// With a generated text.
    #[must_use]
    pub fn generated(mut self, path: &'static str, text: String) -> Self {
        self.generated.push((path, text));
        self
    }

    /// Sharing the struct `T`.
    #[must_use]
    pub fn with<T: GpuStruct>(mut self) -> Self {
        self.structs.push(StructLayout::of::<T>());
        self
    }
}

/// Declares a `#[repr(C)]` struct that a shader shares, with its field table ([`GpuStruct`]) and a
/// `Default` of zeros. Padding must be explicit members, as `bytemuck::Pod` demands; vectors are
/// arrays (`vec3<f32>` = `[f32; 3]` followed by a 4-byte member).
///
/// ```
/// lucarne::gpu_struct! {
///     /// Parameters of a dispatch.
///     pub struct Params {
///         /// First row.
///         pub first: u32,
///         /// Number of rows.
///         pub count: u32,
///     }
/// }
/// assert_eq!(Params { first: 1, count: 2 }.count, 2);
/// ```
#[macro_export]
macro_rules! gpu_struct {
    ($(#[$attribute:meta])* $visibility:vis struct $name:ident { $($(#[$field_attribute:meta])* $field_visibility:vis $field:ident : $type:ty),* $(,)? }) => {
        $(#[$attribute])*
        #[repr(C)]
        #[derive(Debug, Clone, Copy, PartialEq, $crate::gpu::bytemuck::Pod, $crate::gpu::bytemuck::Zeroable)]
        $visibility struct $name { $($(#[$field_attribute])* $field_visibility $field: $type),* }

        impl Default for $name {
            fn default() -> Self {
                $crate::gpu::bytemuck::Zeroable::zeroed()
            }
        }

        impl $crate::gpu::GpuStruct for $name {
            const NAME: &'static str = stringify!($name);
            const FIELDS: &'static [$crate::gpu::Field] = &[
                $($crate::gpu::Field {
                    name: stringify!($field),
                    offset: ::std::mem::offset_of!($name, $field),
                    size: ::std::mem::size_of::<$type>(),
                }),*
            ];
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    crate::gpu_struct! {
        struct Probe {
            origin: [f32; 3],
            count: u32,
            weights: [[f32; 4]; 2],
            scale: [f32; 2],
            rest: [u32; 2],
        }
    }

    fn differences(wgsl: &str) -> Vec<String> {
        StructLayout::of::<Probe>().differences(&naga::front::wgsl::parse_str(wgsl).unwrap())
    }

    #[test]
    fn equal_layouts_agree_and_every_kind_of_difference_is_seen() {
        let good = "struct Probe { origin: vec3<f32>, count: u32, weights: array<vec4<f32>, 2>, scale: vec2<f32>, rest: vec2<u32> }";
        assert!(differences(good).is_empty(), "{:?}", differences(good));
        assert!(!differences(&good.replace("origin: vec3<f32>, count: u32", "count: u32, origin: vec3<f32>")).is_empty());
        assert!(!differences(&good.replace("scale", "skale")).is_empty());
        assert!(!differences(&good.replace(", rest: vec2<u32>", "")).is_empty());
        assert!(!differences(&good.replace("weights: array<vec4<f32>, 2>", "weights: array<vec4<f32>, 3>")).is_empty());
        assert!(!differences("struct Other { a: u32 }").is_empty());
    }
}
