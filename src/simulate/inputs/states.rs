//! The façade as it is through the year: which window is in which state when.

use super::Inputs;
use super::suns::SunSet;
use super::windows::{ProjectWindow, WindowState};
use crate::control::{Schedule, State, read};
use crate::error::{Result, Warnings};
use crate::matrix::Matrix;
use crate::metrics::Year;
use crate::scene::Window;
use crate::simulate::project::Project;
use crate::simulate::project::control::Asked;
use crate::simulate::store::fingerprint::Fingerprint;
use crate::weather::Weather;

/// What a window is in some time steps.
#[derive(Debug, Clone)]
pub struct WindowUse<'a> {
    /// T.
    pub transmission: &'a Matrix<f64>,
    /// Whether its sun is traced.
    pub is_sunny: bool,
    /// Whether it is so in each time step of the year; nothing if it always is.
    pub steps: Option<Vec<bool>>,
}

impl WindowUse<'_> {
    /// Whether it is so in a time step.
    pub fn holds(&self, step: usize) -> bool {
        self.steps.as_ref().is_none_or(|steps| steps[step])
    }
}

/// The states that a project asks for, `[group][step]`.
///
/// # Errors
/// Schedules that do not fit the year or the group.
pub(super) fn schedule(project: &Project, weather: &Weather) -> Result<Schedule> {
    let facade = &project.facade;
    let (year, steps) = (Year::of(weather), weather.records.len());
    let mut states = vec![vec![0; steps]; facade.groups().len()];
    for control in &project.control.groups {
        let group = &facade.groups()[control.group];
        states[control.group] = match &control.asked {
            Asked::Stays(state) => vec![*state; steps],
            Asked::Schedule(file) => read(file, group, &year).map_err(|e| control.place.of(e))?,
            // Until the run decides they take turns, so that what is made before serves all of them.
            Asked::Rule(..) | Asked::Optimal | Asked::Lm83 { .. } => (0..steps).map(|s| (s % group.states.len()) as State).collect(),
        };
    }
    Schedule::new(facade, steps, states)
}

impl Inputs {
    /// Whether any window changes its state, or may still: what the run has not decided yet counts as moving.
    pub fn moves(&self) -> bool {
        !self.undecided.is_empty() || (0..self.schedule.groups()).any(|group| self.schedule.constant_state(group).is_none())
    }

    /// The same with another schedule. Windows of groups that never change show their one state, the others the first.
    #[must_use]
    pub fn with_schedule(&self, schedule: Schedule) -> Self {
        let mut same = self.clone();
        for window in &mut same.windows {
            if let Some(group) = window.group {
                window.take_state(schedule.constant_state(group).unwrap_or(0));
            }
        }
        (same.schedule, same.undecided) = (schedule, Vec::new());
        same
    }

    /// The same façade in one state of each group for ever.
    ///
    /// # Panics
    /// If there are not as many states as groups, or no such one.
    #[must_use]
    pub fn in_states(&self, states: &[State]) -> Self {
        let steps = self.weather.records.len();
        self.with_schedule(Schedule::constant(&self.facade, steps, states).expect("states of the groups"))
    }

    /// The same as it would be without control: as it is if nothing moves, else in the first state of the groups that do.
    #[must_use]
    pub fn at_rest(&self) -> Self {
        let states: Vec<State> = (0..self.schedule.groups()).map(|g| self.schedule.constant_state(g).unwrap_or(0)).collect();
        self.in_states(&states)
    }

    /// The same where suns pass these windows only.
    #[must_use]
    pub(crate) fn with_suns_through(&self, windows: &[usize]) -> Self {
        let mut same = self.clone();
        for (number, window) in same.windows.iter_mut().enumerate() {
            if !windows.contains(&number) {
                (window.shade, window.pane) = (None, None);
            }
        }
        same
    }

    /// Numbers of the windows of a group.
    pub fn windows_of_group(&self, group: usize) -> Vec<usize> {
        (0..self.windows.len()).filter(|i| self.windows[*i].group == Some(group)).collect()
    }

    /// Numbers of the windows without states.
    pub fn windows_without_states(&self) -> Vec<usize> {
        (0..self.windows.len()).filter(|i| self.windows[*i].group.is_none()).collect()
    }

    /// What a window is through the year: each state that it is ever in, rising.
    pub fn uses(&self, window: usize) -> Vec<WindowUse<'_>> {
        let window = &self.windows[window];
        let of_state = |number: State, group: usize| -> WindowUse<'_> {
            let state = &window.states[usize::from(number)];
            let steps = self.schedule.of_group(group).iter().map(|s| *s == number).collect();
            WindowUse { transmission: &state.transmission, is_sunny: state.is_sunny(), steps: Some(steps) }
        };
        match window.group.filter(|group| self.schedule.constant_state(*group).is_none()) {
            Some(group) if self.schedule.steps() > 0 => self.schedule.used(group).into_iter().map(|s| of_state(s, group)).collect(),
            _ => vec![WindowUse { transmission: &window.transmission, is_sunny: window.is_sunny(), steps: None }],
        }
    }

    /// Whether the sun of a window is traced in any state that it is ever in.
    pub fn is_sunny(&self, window: usize) -> bool {
        self.uses(window).iter().any(|u| u.is_sunny)
    }

    /// Whether what is outside is seen through a window in any state that it is ever in.
    pub(crate) fn is_seen_through(&self, window: usize) -> bool {
        let window = &self.windows[window];
        let ever = |group: usize| self.used(group).iter().any(|s| window.states[usize::from(*s)].see_through);
        window.group.map_or(window.see_through, ever)
    }

    /// States that windows are ever in, each as a window of its own.
    pub(crate) fn windows_in_use(&self) -> Vec<ProjectWindow> {
        self.windows_in(|group| self.used(group))
    }

    /// States that a group is ever in, or may be, rising.
    pub(super) fn used(&self, group: usize) -> Vec<State> {
        match self.undecided.contains(&group) {
            true => (0..self.facade.groups()[group].states.len()).map(|s| s as State).collect(),
            false => self.schedule.used(group),
        }
    }

    /// The same of all states, used or not.
    pub(crate) fn windows_in_all_states(&self) -> Vec<ProjectWindow> {
        self.windows_in(|group| (0..self.facade.groups()[group].states.len()).map(|s| s as State).collect())
    }

    /// Whether any window is ever so.
    pub(crate) fn any_window(&self, is: impl Fn(&ProjectWindow) -> bool) -> bool {
        if self.moves() { self.windows_in_use().iter().any(is) } else { self.windows.iter().any(is) }
    }

    /// States in which glare is computed beside the façade as it moves, by name: all, if the groups that have several have
    /// as many, so that they change in step. With `[control]` only where no sun is traced through them.
    pub(crate) fn states_alone(&self, project: &Project) -> Vec<(String, Vec<State>)> {
        let groups = self.facade.groups();
        let most = groups.iter().map(|g| g.states.len()).max().unwrap_or(0);
        let in_step = groups.iter().all(|g| g.states.len() == most || g.states.len() == 1);
        if !in_step || (project.control.is_given && self.choice(project).phases == 5) {
            return Vec::new();
        }
        let named = groups.iter().find(|g| g.states.len() == most).map_or(&[][..], |g| &g.states);
        let of = |number: usize| groups.iter().map(|g| if g.states.len() == 1 { 0 } else { number as State }).collect();
        named.iter().enumerate().map(|(number, name)| (name.clone(), of(number))).collect()
    }

    fn windows_in(&self, states: impl Fn(usize) -> Vec<State>) -> Vec<ProjectWindow> {
        let each = |window: &ProjectWindow| -> Vec<ProjectWindow> {
            let Some(group) = window.group else { return vec![window.clone()] };
            let of = |state: &State| {
                let mut same = window.clone();
                same.take_state(*state);
                same
            };
            states(group).iter().map(of).collect()
        };
        self.windows.iter().flat_map(each).collect()
    }

    /// Of each state of a group the first one that suns pass alike.
    pub(crate) fn sun_classes(&self, group: usize) -> Vec<State> {
        let windows = self.windows_of_group(group);
        let alike = |a: usize, b: usize| {
            let of = |w: &usize, s: usize| -> &WindowState { &self.windows[*w].states[s] };
            windows.iter().all(|w| of(w, a).is_passed_as(of(w, b)))
        };
        (0..self.facade.groups()[group].states.len()).map(|b| (0..=b).find(|a| alike(*a, b)).unwrap_or(b) as State).collect()
    }

    /// How many different things suns pass in all states of all groups.
    pub(crate) fn ways_of_suns(&self) -> usize {
        let of_group = |group: usize| {
            let windows = self.windows_of_group(group);
            let mut ways = self.sun_classes(group);
            ways.retain(|s| windows.iter().any(|w| self.windows[*w].states[usize::from(*s)].is_sunny()));
            ways.sort_unstable();
            ways.dedup();
            ways.len()
        };
        let rest = self.windows_without_states().iter().any(|w| self.windows[*w].is_sunny());
        (0..self.facade.groups().len()).map(of_group).sum::<usize>() + usize::from(rest)
    }

    /// What suns ever pass: different states of all groups together, and which of them holds in each time step. States
    /// that suns pass alike count as the first of them.
    pub(crate) fn sun_combinations(&self) -> (Vec<Vec<State>>, Vec<usize>) {
        let groups = self.schedule.groups();
        if !self.moves() {
            let states = (0..groups).map(|g| self.schedule.constant_state(g).unwrap_or(0)).collect();
            return (vec![states], vec![0; self.weather.records.len()]);
        }
        let classes: Vec<Vec<State>> = (0..groups).map(|g| self.sun_classes(g)).collect();
        let mut numbers = std::collections::HashMap::new();
        let mut found: Vec<Vec<State>> = Vec::new();
        let of_step = (0..self.schedule.steps())
            .map(|step| {
                let states: Vec<State> = (0..groups).map(|g| classes[g][usize::from(self.schedule.at(g, step))]).collect();
                *numbers.entry(states.clone()).or_insert_with(|| {
                    found.push(states);
                    found.len() - 1
                })
            })
            .collect();
        (found, of_step)
    }

    /// The suns that any state of any window lets through.
    ///
    /// # Errors
    /// As [`SunSet::new`].
    pub(crate) fn sun_set_of_states(&self, project: &Project) -> Result<SunSet> {
        let sunny = |w: &&ProjectWindow| w.is_sunny() || w.states.iter().any(WindowState::is_sunny);
        let windows: Vec<Window> = self.windows.iter().filter(sunny).map(|w| w.window.clone()).collect();
        let windows = if project.quality.prune { windows } else { Vec::new() };
        SunSet::of(&self.weather, project.method.suns_of(&self.choice(project)), &windows, project.output.quantity)
    }

    /// Windows through which suns are traced, by their shade or their scattering data, in any state that they are ever in.
    /// Of a façade that moves, any state counts: its suns are then the same whatever the schedule.
    pub(crate) fn sunny_windows(&self) -> Vec<Window> {
        let sunny = |i: &usize| match self.moves() {
            true => self.windows[*i].is_sunny() || self.windows[*i].states.iter().any(WindowState::is_sunny),
            false => self.windows[*i].is_sunny(),
        };
        (0..self.windows.len()).filter(sunny).map(|i| self.windows[i].window.clone()).collect()
    }

    /// Adds all T that results depend on, and when they hold.
    pub(crate) fn add_transmissions(&self, fingerprint: &mut Fingerprint) {
        for number in 0..self.windows.len() {
            for used in self.uses(number) {
                fingerprint.add(&used.transmission.data());
                if let Some(steps) = used.steps {
                    fingerprint.add(&steps);
                }
            }
        }
    }

    /// Faults of a façade that moves, and what there is to say of its states.
    pub(super) fn check_states(&self, project: &Project, warnings: &mut Warnings) -> Result<()> {
        let phases = self.choice(project).phases;
        let told = |text: &str| {
            let place = project.control.groups.first().map(|g| &g.place);
            let error = crate::error::Error::new(text);
            place.map_or(error.clone(), |place| place.of(error))
        };
        if self.moves() && phases == 2 {
            return Err(told("phases = 2 keeps daylight coefficients V·T·D, which are of one state, but the windows change theirs")
                .help("write phases = 3 or \"auto\", or give each group one state in [control]"));
        }
        if self.moves() && phases == 5 && project.images.components {
            return Err(told("the suns' component pictures are of one state, but the windows change theirs")
                .help("take 'components' out of [images], or give each group one state in [control]"));
        }
        self.glare_of_states(project)?;
        let has_results = !project.sensors.is_empty() || project.images.hours != crate::simulate::project::views::ImageHours::None;
        let unsaid = |g: &usize| self.facade.groups()[*g].states.len() > 1 && !project.control.groups.iter().any(|c| c.group == *g);
        if let Some(group) = (0..self.facade.groups().len()).find(unsaid).filter(|_| has_results && !project.control.is_given) {
            let group = &self.facade.groups()[group];
            warnings.push(
                crate::error::Error::new(format!(
                    "nothing decides the state of the windows '{}': results are those of the first, '{}'",
                    group.name, group.states[0]
                ))
                .file(&project.file)
                .help(format!("add [control] with {} = \"….csv\" (a state per time step), or the name of a state", group.name)),
            );
        }
        Ok(())
    }
}
