//! The part of `product/gemm_subgroup` that depends on the number of lanes.

use crate::gpu::Declared;
use std::fmt::Write;

/// For subgroups of so many lanes.
pub(super) const FOUR: &[Declared] = &[Declared { name: "tile", wgsl: || wgsl(4) }];
pub(super) const EIGHT: &[Declared] = &[Declared { name: "tile", wgsl: || wgsl(8) }];
pub(super) const SIXTEEN: &[Declared] = &[Declared { name: "tile", wgsl: || wgsl(16) }];

/// Rows of the tile of a subgroup with this many lanes.
pub(super) fn rows(lanes: u32) -> u32 {
    4 * lanes
}

/// Columns of the tile of a subgroup with this many lanes.
pub(super) fn columns(lanes: u32) -> u32 {
    8 * lanes
}

/// `LANES`, and the loop over the terms with a variable `r‹row›a` and `r‹row›b` for the two quads of
/// sums of each row.
fn wgsl(lanes: u32) -> String {
    let mut text = format!("const LANES: u32 = {lanes}u;\n");
    text.push_str("fn tile(first_left: u32, first_right: u32, row: u32, column: u32, component: u32) {\n");
    text.push_str("    var left_at = first_left;\n    var right_at = first_right;\n");
    for row in 0..rows(lanes) {
        let _ = writeln!(text, "    var r{row}a = vec4<f32>();\n    var r{row}b = vec4<f32>();");
    }
    text.push_str("    for (var term = 0u; term < params.inner; term++) {\n");
    text.push_str("        let rows = left[left_at];\n        let a = right[right_at];\n        let b = right[right_at + LANES];\n");
    for row in 0..rows(lanes) {
        let component = ["x", "y", "z", "w"][row as usize % 4];
        let _ = writeln!(text, "        let s{row} = vec4<f32>(subgroupBroadcast(rows.{component}, {}u));", row / 4);
        let _ = writeln!(text, "        r{row}a = fma(s{row}, a, r{row}a);\n        r{row}b = fma(s{row}, b, r{row}b);");
    }
    text.push_str("        left_at += params.left_stride;\n        right_at += params.right_stride;\n    }\n");
    for row in (0..rows(lanes)).step_by(4) {
        for (quad, offset) in [("a", 0), ("b", 4 * lanes)] {
            let sums: Vec<String> = (row..row + 4).map(|r| format!("r{r}{quad}")).collect();
            let _ = writeln!(text, "    store_block(row + {row}u, column + {offset}u, component, {});", sums.join(", "));
        }
    }
    text.push_str("}\n");
    text
}
