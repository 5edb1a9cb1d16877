//! Shaders in use, and what host and shader share: structs and numbers stand once, in Rust, and the
//! linker gives them to WGSL as `package::generated`.

use super::sources;
use bytemuck::Pod;
use std::borrow::Cow;

/// Path of the text that is made of a shader's [`Declared`] structs and numbers.
pub(super) const GENERATED: &str = "generated";

/// A struct or number that host and shader share: what [`gpu_struct!`](crate::gpu_struct) and
/// [`gpu_constants!`](crate::gpu_constants) make for WGSL.
#[derive(Debug, Clone, Copy)]
pub struct Declared {
    /// Name, the same in Rust and WGSL.
    pub name: &'static str,
    /// Its WGSL.
    pub wgsl: fn() -> String,
}

/// The shader of a kernel: a file below `shaders/`, with what it may import from
/// `package::generated`.
#[derive(Debug, Clone, Copy)]
pub struct Shader {
    path: &'static str,
    declared: &'static [&'static [Declared]],
    shared: &'static [&'static [Declared]],
    /// In place of the file's text.
    text: Option<&'static str>,
}

impl Shader {
    /// The shader in `shaders/<path>.wgsl`. It and the files that it imports may import what is
    /// `declared`, and need not.
    pub const fn new(path: &'static str, declared: &'static [&'static [Declared]]) -> Self {
        Self { path, declared, shared: &[], text: None }
    }

    /// The same that may import more, which many shaders share.
    #[must_use]
    pub const fn sharing(self, shared: &'static [&'static [Declared]]) -> Self {
        Self { shared, ..self }
    }

    /// A shader without a file.
    #[cfg(test)]
    pub(crate) const fn of_text(path: &'static str, declared: &'static [&'static [Declared]], text: &'static str) -> Self {
        Self { path, declared, shared: &[], text: Some(text) }
    }

    /// Path below `shaders/` without `.wgsl`.
    pub fn path(&self) -> &'static str {
        self.path
    }

    /// What it may import from `package::generated`.
    pub fn declared(&self) -> impl Iterator<Item = &'static Declared> + use<> {
        self.declared.iter().chain(self.shared).copied().flatten()
    }

    /// The text at a path below `shaders/`.
    pub(super) fn file(&self, path: &str) -> Option<Cow<'static, str>> {
        match (path, self.text) {
            (GENERATED, _) => Some(self.declared().map(|d| (d.wgsl)()).collect::<String>().into()),
            (_, Some(text)) if path == self.path => Some(text.into()),
            _ => sources::source(path).map(Cow::Borrowed),
        }
    }
}

/// A type of struct members.
pub trait Member: Pod {
    /// Name in WGSL.
    const WGSL: &'static str;
    /// Alignment in WGSL, bytes; the size is that in Rust.
    const ALIGN: usize;
}

macro_rules! members {
    ($($type:ty: $name:literal, $align:literal;)*) => {
        $(impl Member for $type {
            const WGSL: &'static str = $name;
            const ALIGN: usize = $align;
        })*
    };
}

members! {
    u32: "u32", 4;
    f32: "f32", 4;
    [u32; 2]: "vec2<u32>", 8;
    [f32; 2]: "vec2<f32>", 8;
    [f32; 3]: "vec3<f32>", 16;
    [f32; 4]: "vec4<f32>", 16;
}

/// Where WGSL puts the members of a struct.
#[doc(hidden)]
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    /// Offset of the latest member, bytes.
    pub last: usize,
    end: usize,
    align: usize,
}

impl Layout {
    /// Before the first member.
    pub const START: Self = Self { last: 0, end: 0, align: 1 };

    /// With another member.
    #[must_use]
    pub const fn then<T: Member>(self) -> Self {
        let last = self.end.next_multiple_of(T::ALIGN);
        Self { last, end: last + size_of::<T>(), align: if T::ALIGN > self.align { T::ALIGN } else { self.align } }
    }

    /// Size of the struct, bytes.
    pub const fn size(self) -> usize {
        self.end.next_multiple_of(self.align)
    }
}

/// A number that is a constant in WGSL. What is f64 in Rust is rounded to f32 by the shader's compiler.
pub trait Number {
    /// Type in WGSL.
    const WGSL: &'static str;
    /// As WGSL writes it.
    fn literal(self) -> String;
}

impl Number for u32 {
    const WGSL: &'static str = "u32";
    fn literal(self) -> String {
        format!("{self}u")
    }
}

impl Number for f64 {
    const WGSL: &'static str = "f32";
    fn literal(self) -> String {
        format!("{self:?}")
    }
}

#[doc(hidden)]
pub fn wgsl_struct(name: &str, members: &[(&str, &str)], atomic: bool) -> String {
    let mut text = format!("struct {name} {{\n");
    for (member, wgsl) in members {
        text += &if atomic { format!("    {member}: atomic<{wgsl}>,\n") } else { format!("    {member}: {wgsl},\n") };
    }
    text + "}\n"
}

/// A function that makes a struct of its quads of words: `material_of(words0, words1, …)` for `Material`.
#[doc(hidden)]
pub fn wgsl_of_words(name: &str, members: &[(&str, usize)], size: usize) -> String {
    let words: Vec<String> = (0..size / 16).map(|quad| format!("words{quad}: vec4<u32>")).collect();
    let member = |&(wgsl, offset): &(&str, usize)| {
        let first = offset % 16 / 4;
        let components = match wgsl.as_bytes() {
            [b'v', b'e', b'c', n, ..] => usize::from(n - b'0'),
            _ => 1,
        };
        format!("bitcast<{wgsl}>(words{}.{})", offset / 16, &"xyzw"[first..first + components])
    };
    let members: Vec<String> = members.iter().map(member).collect();
    let function: String =
        name.char_indices().flat_map(|(i, c)| (i > 0 && c.is_uppercase()).then_some('_').into_iter().chain(c.to_lowercase())).collect();
    format!("fn {function}_of({}) -> {name} {{\n    return {name}({});\n}}\n", words.join(", "), members.join(", "))
}

#[doc(hidden)]
pub fn wgsl_constant<T: Number>(name: &str, value: T) -> String {
    format!("const {name}: {} = {};\n", T::WGSL, value.literal())
}

/// Declares a `#[repr(C)]` struct that a shader shares: `DECLARED` is its WGSL (for [`Shader::new`]),
/// its `Default` is zeros. Two to four numbers are a vector in WGSL. Padding must be explicit members
/// such that Rust and WGSL put all members at the same place; what differs does not compile. With
/// `: atomic` after the name, shaders change the members by atomic operations.
///
/// ```
/// lucarne::gpu_struct! {
///     /// Parameters of a dispatch.
///     pub struct Params {
///         /// Where light comes from.
///         pub origin: [f32; 3],
///         /// Number of rows.
///         pub count: u32,
///     }
/// }
/// assert_eq!((Params::DECLARED.wgsl)(), "struct Params {\n    origin: vec3<f32>,\n    count: u32,\n}\n");
/// ```
///
/// ```compile_fail
/// lucarne::gpu_struct! {
///     struct Params {
///         count: u32,
///         // In WGSL at 16 bytes, not at 4.
///         origin: [f32; 3],
///     }
/// }
/// ```
#[macro_export]
macro_rules! gpu_struct {
    ($(#[$attribute:meta])* $visibility:vis struct $name:ident $(: $atomic:ident)? { $($(#[$field_attribute:meta])* $field_visibility:vis $field:ident : $type:ty),* $(,)? }) => {
        $(#[$attribute])*
        #[repr(C)]
        #[derive(Debug, Clone, Copy, PartialEq, $crate::gpu::bytemuck::Pod, $crate::gpu::bytemuck::Zeroable)]
        $visibility struct $name { $($(#[$field_attribute])* $field_visibility $field: $type),* }

        impl Default for $name {
            fn default() -> Self {
                $crate::gpu::bytemuck::Zeroable::zeroed()
            }
        }

        impl $name {
            /// For the shaders.
            $visibility const DECLARED: $crate::gpu::Declared = $crate::gpu::Declared {
                name: stringify!($name),
                wgsl: || $crate::gpu::wgsl_struct(
                    stringify!($name),
                    &[$((stringify!($field), <$type as $crate::gpu::Member>::WGSL)),*],
                    [$(stringify!($atomic)),*].contains(&"atomic"),
                ),
            };

            /// For shaders that read it from a buffer of words: the function that makes it of its quads of them.
            #[allow(dead_code, reason = "most structs have buffers of their own")]
            $visibility const OF_WORDS: $crate::gpu::Declared = $crate::gpu::Declared {
                name: stringify!($name),
                wgsl: || $crate::gpu::wgsl_of_words(
                    stringify!($name),
                    &[$((<$type as $crate::gpu::Member>::WGSL, ::std::mem::offset_of!($name, $field))),*],
                    size_of::<$name>(),
                ),
            };
        }

        const _: () = {
            let layout = $crate::gpu::Layout::START;
            $(
                let layout = layout.then::<$type>();
                assert!(
                    ::std::mem::offset_of!($name, $field) == layout.last,
                    concat!("WGSL puts the member '", stringify!($field), "' elsewhere: add padding before it")
                );
            )*
            assert!(size_of::<$name>() == layout.size(), concat!("'", stringify!($name), "' is larger in WGSL: add padding at its end"));
        };
    };
}

/// Declares numbers that shaders share, and the list of them for [`Shader::new`].
///
/// ```
/// lucarne::gpu_constants! {
///     pub const SHARED = {
///         /// Specular reflectance from which Fresnel's law counts.
///         pub const FRESNEL_THRESHOLD: f64 = 0.018;
///     }
/// }
/// assert_eq!((SHARED[0].wgsl)(), "const FRESNEL_THRESHOLD: f32 = 0.018;\n");
/// ```
#[macro_export]
macro_rules! gpu_constants {
    ($list_visibility:vis const $list:ident = { $($(#[$attribute:meta])* $visibility:vis const $name:ident : $type:ty = $value:expr;)* }) => {
        $($(#[$attribute])* $visibility const $name: $type = $value;)*

        /// For the shaders.
        $list_visibility const $list: &[$crate::gpu::Declared] = &[
            $($crate::gpu::Declared { name: stringify!($name), wgsl: || $crate::gpu::wgsl_constant(stringify!($name), $name) }),*
        ];
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    crate::gpu_struct! {
        struct Probe {
            origin: [f32; 3],
            count: u32,
            weights: [f32; 4],
            scale: [f32; 2],
            rest: [u32; 2],
            last: f32,
            padding: u32,
            more: [u32; 2],
        }
    }

    crate::gpu_struct! {
        struct Counts: atomic {
            one: u32,
            two: u32,
        }
    }

    crate::gpu_constants! {
        const NUMBERS = {
            const MANY: u32 = u32::MAX;
            const FAR: f64 = 1e30;
            const SHARE: f64 = std::f64::consts::FRAC_1_PI;
        }
    }

    /// naga's opinion of the rules by which [`Layout`] works.
    #[test]
    fn members_lie_where_naga_puts_them() {
        let text = Shader::new("t/none", &[&[Probe::DECLARED, Counts::DECLARED]]).file(GENERATED).unwrap();
        let module = naga::front::wgsl::parse_str(&text).unwrap();
        let found = |name: &str| {
            let (_, found) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name)).unwrap();
            let naga::TypeInner::Struct { members, span } = &found.inner else { panic!("{found:?}") };
            (members.iter().map(|m| m.offset as usize).collect::<Vec<_>>(), *span as usize)
        };
        use std::mem::offset_of;
        let offsets = [
            offset_of!(Probe, origin),
            offset_of!(Probe, count),
            offset_of!(Probe, weights),
            offset_of!(Probe, scale),
            offset_of!(Probe, rest),
            offset_of!(Probe, last),
            offset_of!(Probe, padding),
            offset_of!(Probe, more),
        ];
        assert_eq!(found("Probe"), (offsets.to_vec(), size_of::<Probe>()));
        assert_eq!(found("Counts"), (vec![offset_of!(Counts, one), offset_of!(Counts, two)], size_of::<Counts>()));
        let words = (Probe::OF_WORDS.wgsl)();
        assert_eq!(
            words,
            "fn probe_of(words0: vec4<u32>, words1: vec4<u32>, words2: vec4<u32>, words3: vec4<u32>) -> Probe {\n    return Probe(\
             bitcast<vec3<f32>>(words0.xyz), bitcast<u32>(words0.w), bitcast<vec4<f32>>(words1.xyzw), \
             bitcast<vec2<f32>>(words2.xy), bitcast<vec2<u32>>(words2.zw), bitcast<f32>(words3.x), bitcast<u32>(words3.y), \
             bitcast<vec2<u32>>(words3.zw));\n}\n"
        );
        naga::front::wgsl::parse_str(&(text.clone().into_owned() + &words)).unwrap();
        assert!(text.ends_with("struct Counts {\n    one: atomic<u32>,\n    two: atomic<u32>,\n}\n"), "{text}");
    }

    #[test]
    fn numbers_keep_their_value() {
        let text = Shader::new("t/none", &[NUMBERS]).file(GENERATED).unwrap();
        let module = naga::front::wgsl::parse_str(&text).unwrap();
        let value = |name: &str| {
            let (_, constant) = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name)).unwrap();
            module.global_expressions[constant.init].clone()
        };
        let literal = naga::Expression::Literal;
        assert_eq!(value("MANY"), literal(naga::Literal::U32(MANY)));
        assert_eq!(value("FAR"), literal(naga::Literal::F32(FAR as f32)));
        assert_eq!(value("SHARE"), literal(naga::Literal::F32(SHARE as f32)));
    }
}
