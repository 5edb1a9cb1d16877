//! Whether a sky made elsewhere has what a project's method asks of it.

use crate::bins::ReinhartSky;
use crate::error::{Error, Result};
use crate::simulate::project::Project;
use crate::simulate::project::method::{Choice, SunScheme};
use crate::weather::given::GivenSky;

/// The division of the sky, which that of V, D and the coefficients is too.
///
/// # Errors
/// Another division or other suns than the project asks for; a direct part or suns that the method needs and that are
/// not given.
pub(super) fn check(project: &Project, choice: &Choice, given: &GivenSky) -> Result<ReinhartSky> {
    let fault = |text: String, field: &str, help: &str| Err(Error::new(text).file(&project.file).field(field).help(help));
    let Some(sky) = ReinhartSky::from_bins(given.whole.rows()) else {
        return fault("the matrix is no sky".into(), "weather.sky_matrix", "make it with gendaymtx");
    };
    if let Some(asked) = project.method.sky.filter(|asked| *asked != sky) {
        let text = format!("the sky that is given is MF:{}, not MF:{}", sky.subdivision(), asked.subdivision());
        return fault(text, "method.sky_subdivision", "take 'sky_subdivision' out: it follows the matrix");
    }
    if choice.phases != 5 {
        return Ok(sky);
    }
    let why = format!("the method ({}) takes the sun out of the sky and traces it for itself", choice.formula());
    const OR_THREE: &str = "or write phases = 3 in [method] where there are windows: then the sun stays in the sky's patches";
    if given.direct.is_none() {
        let help =
            format!("add sky_matrix_direct = \"….mtx\" (the same gendaymtx with -d), or \"none\" where the sky holds no sun; {OR_THREE}");
        return fault(format!("{why}; its share of the sky is not given"), "weather.sky_matrix_direct", &help);
    }
    let Some((subdivision, suns)) = &given.suns else {
        let help = format!("add sun_matrix = \"….mtx\" (gendaymtx -5 0.533 -d -m 6); {OR_THREE}");
        return fault(format!("{why}; the suns are not given"), "weather.sun_matrix", &help);
    };
    let fits = match project.method.suns {
        SunScheme::Patches(asked) => asked.subdivision() == *subdivision,
        SunScheme::Hourly { .. } => false,
    };
    if project.method.suns_are_given && !fits && suns.iter().any(Option::is_some) {
        let text = format!("the suns that are given are those of MF:{subdivision}");
        return fault(text, "method.suns", "take 'suns' out: they follow the matrix");
    }
    Ok(sky)
}
