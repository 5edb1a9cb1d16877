//! Lists to choose from, by pointer and by keys.

use eframe::egui::{self, Key, Modifiers};

/// A list that opens under a button. While it is open its keys stay in it: ↑, ↓, Home and End choose,
/// Enter closes.
pub fn choose<T: PartialEq + Copy>(
    ui: &mut egui::Ui,
    list: egui::ComboBox<'_>,
    shown: &str,
    choices: impl IntoIterator<Item = (T, String)>,
    chosen: &mut T,
) {
    list.selected_text(shown).show_ui(ui, |ui| {
        let choices: Vec<(T, String)> = choices.into_iter().collect();
        let moved = moved(ui, choices.iter().position(|c| c.0 == *chosen), choices.len());
        if let Some(to) = moved {
            *chosen = choices[to].0;
        }
        for (i, (choice, name)) in choices.iter().enumerate() {
            let label = ui.selectable_value(chosen, *choice, name.as_str());
            if moved == Some(i) {
                label.scroll_to_me(None);
            }
        }
        if ui.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Enter)) {
            ui.close();
        }
    });
}

/// Where the keys of this frame lead from the choice of now.
fn moved(ui: &egui::Ui, now: Option<usize>, count: usize) -> Option<usize> {
    let last = count.checked_sub(1)?;
    let pressed = |key: Key| ui.input_mut(|i| i.consume_key(Modifiers::NONE, key));
    let mut to = None;
    if pressed(Key::ArrowDown) {
        to = Some(now.map_or(0, |n| (n + 1).min(last)));
    }
    if pressed(Key::ArrowUp) {
        to = Some(now.map_or(last, |n| n.saturating_sub(1)));
    }
    if pressed(Key::Home) {
        to = Some(0);
    }
    if pressed(Key::End) {
        to = Some(last);
    }
    to
}
