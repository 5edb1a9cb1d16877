//! Shades described in one line: `key=value,…`.

use lucarne::bsdf::blinds::Venetian;
use lucarne::kernels::bsdf_generation::Sample;
use lucarne::scene::{Material, MaterialIndex, MaterialKind, Scene, SurfaceOrigin, Triangle};
use lucarne::{Error, Result, Warnings};
use std::collections::BTreeMap;

/// Metres per unit.
pub(super) fn unit(name: &str) -> Result<f64> {
    Ok(match name.to_ascii_lowercase().as_str() {
        "m" | "meter" | "metre" => 1.0,
        "cm" | "centimeter" => 0.01,
        "mm" | "millimeter" => 0.001,
        "in" | "inch" => 0.0254,
        "ft" | "foot" | "feet" => 0.3048,
        other => return Err(Error::new(format!("'{other}' is no unit of length")).help("choose m, cm, mm, in or ft")),
    })
}

/// `key=value,…` of a parametric shade.
pub(super) struct Parameters(BTreeMap<String, String>);

impl Parameters {
    pub(super) fn parse(text: &str, known: &[&str]) -> Result<Self> {
        let mut found = BTreeMap::new();
        for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            let (key, value) = part.split_once('=').ok_or_else(|| Error::new(format!("'{part}' is not key=value")))?;
            let (key, value) = (key.trim(), value.trim());
            if !known.contains(&key) {
                return Err(Error::new(format!("'{key}' is unknown")).help(format!("known are {}", known.join(", "))));
            }
            if found.insert(key.to_string(), value.to_string()).is_some() {
                return Err(Error::new(format!("'{key}' is given twice")));
            }
        }
        Ok(Self(found))
    }

    fn number(&self, key: &str) -> Result<Option<f64>> {
        let fault = |v: &str| Error::new(format!("{key}={v} is not a number"));
        self.0.get(key).map(|v| v.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(|| fault(v))).transpose()
    }

    pub(super) fn share(&self, key: &str) -> Result<Option<f64>> {
        let found = self.number(key)?;
        match found.filter(|v| !(0.0..=1.0).contains(v)) {
            Some(v) => Err(Error::new(format!("{key}={v} is not between 0 and 1"))),
            None => Ok(found),
        }
    }

    /// A length with its unit, in metres.
    pub(super) fn length(&self, key: &str) -> Result<Option<f64>> {
        let Some(value) = self.0.get(key) else { return Ok(None) };
        let letters = value.trim_end_matches(|c: char| c.is_ascii_alphabetic());
        let (number, name) = (letters.trim(), value[letters.len()..].trim());
        let number: f64 =
            number.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| {
                Error::new(format!("{key}={value} is not a length")).help("give a number with its unit, for instance 25mm")
            })?;
        if name.is_empty() && number != 0.0 {
            return Err(Error::new(format!("{key}={value} has no unit")).help(format!("for instance {key}={value}mm")));
        }
        Ok(Some(number * if name.is_empty() { 1.0 } else { unit(name).map_err(|e| e.field(key))? }))
    }
}

pub(super) fn required<T>(value: Option<T>, key: &str) -> Result<T> {
    value.ok_or_else(|| Error::new(format!("{key} is missing")).help("for instance width=25mm,spacing=20mm,angle=20,reflectance=0.5"))
}

/// One period of slats, for visible or for solar light.
pub(super) fn venetian(text: &str, solar: bool, warnings: &mut Warnings) -> Result<Sample> {
    let known = [
        "width",
        "spacing",
        "angle",
        "rise",
        "curvature",
        "thickness",
        "reflectance",
        "transmittance",
        "solar_reflectance",
        "solar_transmittance",
        "specularity",
        "roughness",
    ];
    let given = Parameters::parse(text, &known)?;
    let width = required(given.length("width")?, "width")?;
    let rise = match (given.length("rise")?, given.length("curvature")?) {
        (Some(_), Some(_)) => return Err(Error::new("rise and curvature say the same").help("give one of them")),
        (Some(rise), None) => rise,
        // WINDOW's curvature is a radius, 0 for flat slats.
        (None, Some(radius)) if radius != 0.0 => {
            if radius.abs() < width / 2.0 {
                return Err(Error::new(format!("a radius of {radius} m is less than half the slat's width")).field("curvature"));
            }
            radius.signum() * (radius.abs() - (radius * radius - width * width / 4.0).sqrt())
        }
        _ => 0.0,
    };
    let blind = Venetian {
        width,
        spacing: required(given.length("spacing")?, "spacing")?,
        angle: given.number("angle")?.unwrap_or(0.0),
        rise,
        thickness: given.length("thickness")?.unwrap_or(0.0),
    };
    let visible = [Some(required(given.share("reflectance")?, "reflectance")?), given.share("transmittance")?];
    let solar_values = [given.share("solar_reflectance")?, given.share("solar_transmittance")?];
    let [reflectance, transmittance] = [0, 1].map(|k| if solar { solar_values[k].or(visible[k]) } else { visible[k] }.unwrap_or(0.0));
    let specularity = given.share("specularity")?.unwrap_or(0.0);
    let roughness = given.share("roughness")?.unwrap_or(0.0);
    let kind = slat_material(reflectance, transmittance, specularity, roughness)?;
    if transmittance > 0.0 && blind.thickness > 0.0 {
        return Err(Error::new("translucent slats are sheets: light passes their one surface")
            .field("thickness")
            .help("leave out the thickness"));
    }
    let period = blind.period()?;
    let scene = Scene {
        triangles: period.triangles.iter().map(|&vertices| Triangle { vertices, material: MaterialIndex(0), surface: 0 }).collect(),
        materials: vec![Material { name: "slat".into(), kind }],
        surfaces: vec![SurfaceOrigin { name: "slat".into(), file: "--venetian".into(), line: 0 }],
        ..Scene::default()
    };
    let (low, high) = (period.low, period.high);
    Sample::new(scene, Some([low.x, high.x, low.y, high.y, low.z, high.z]), [true, true], warnings)
}

/// A material of this reflectance in total, of which `specularity` is specular, and this diffuse
/// transmittance.
fn slat_material(reflectance: f64, transmittance: f64, specularity: f64, roughness: f64) -> Result<MaterialKind> {
    if reflectance + transmittance > 1.0 {
        return Err(Error::new(format!("reflectance {reflectance} and transmittance {transmittance} together exceed 1")));
    }
    if transmittance == 0.0 {
        // Coloured by the reflectance in both parts.
        let color = [reflectance; 3];
        return Ok(if specularity > 0.0 {
            MaterialKind::Metal { color, specularity, roughness }
        } else {
            MaterialKind::Plastic { color, specularity: 0.0, roughness: 0.0 }
        });
    }
    let specular = reflectance * specularity;
    let diffuse = reflectance + transmittance - specular;
    let color = [if specular < 1.0 { diffuse / (1.0 - specular) } else { 0.0 }; 3];
    Ok(MaterialKind::Trans {
        color,
        specularity: specular,
        roughness,
        transmissivity: transmittance / diffuse.max(1e-12),
        transmitted_specularity: 0.0,
    })
}
