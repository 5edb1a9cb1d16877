//! Writes VALIDATION.md: `template.md` with what tests and benchmarks measured in its places. `make validation`.

mod document;
#[path = "../../src/testing.rs"]
mod testing;

fn main() -> std::io::Result<()> {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("VALIDATION.md");
    let present = std::fs::read_to_string(&file).unwrap_or_default();
    let (text, kept) = document::fill(include_str!("template.md"), &present, testing::measurement);
    std::fs::write(file, text)?;
    if !kept.is_empty() {
        println!("nothing was measured in place of {} (test skipped, or its key asks for a bound that it does not give)", kept.join(", "));
    }
    Ok(())
}
