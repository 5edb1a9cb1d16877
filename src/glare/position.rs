//! Position index and field of view.

use super::geometry::{ViewFrame, dot};

/// How much less a source disturbs away from the line of sight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PositionIndex {
    /// Guth's above the line of sight (as fitted in the IES Lighting Handbook); below it
    /// P = exp(6.49e-3 β + 21e-5 β²) with β = atan(tan σ √(1 + 0.3225 cos² τ)) in degrees, as
    /// evalglare since 3.02. At most 16.
    #[default]
    Guth,
    /// Guth's above the line of sight, Iwata's (1997) 1 + 0.8 R (1 + 1.2 R from R = 0.6) below, as
    /// evalglare before 3.02 and `dcglare`. At most 16.
    GuthIwata,
    /// Kim's (W. Kim and J. T. Kim, 2010), all around.
    Kim,
}

/// Greatest value of Guth's position index.
const GREATEST: f64 = 16.0;

/// Angles of a direction in a view, degrees: `sigma` from the view direction, `tau` from upwards
/// (0 above, 90 beside, 180 below), around the view direction. If the up vector is not across the
/// view direction (see [`ViewFrame::squared`]), `tau` is the angle to that tilted vector.
pub(crate) fn angles(frame: &ViewFrame, direction: [f64; 3]) -> (f64, f64) {
    let ahead = dot(direction, frame.forward);
    let (up, right) = (dot(direction, frame.up), dot(direction, frame.right));
    let across = up.hypot(right);
    let sigma = across.atan2(ahead).to_degrees();
    if across < 1e-12 {
        return (sigma, 0.0);
    }
    let tilt = ((1.0 - frame.up_length * frame.up_length).max(0.0) * up * up + right * right).sqrt();
    (sigma, tilt.atan2(frame.up_length * up).to_degrees())
}

impl PositionIndex {
    /// Position index of a direction; 1 on the line of sight (Kim's may be less than 1).
    pub fn of(self, frame: &ViewFrame, direction: [f64; 3]) -> f64 {
        let (sigma, tau) = angles(frame, direction);
        // Nothing behind the viewer is seen; a pixel on the rim may be out by its own size.
        let sigma = sigma.min(90.0);
        match self {
            Self::Guth if tau > 90.0 => below(sigma, tau).min(GREATEST),
            Self::GuthIwata if tau > 90.0 => iwata(sigma).min(GREATEST),
            Self::Guth | Self::GuthIwata => guth(sigma, tau).min(GREATEST),
            Self::Kim => kim(sigma, tau),
        }
    }
}

fn guth(sigma: f64, tau: f64) -> f64 {
    let linear = 35.2 - 0.31889 * tau - 1.22 * (-2.0 * tau / 9.0).exp();
    let quadratic = 21.0 + 0.26667 * tau - 0.002_963 * tau * tau;
    (linear * 1e-3 * sigma + quadratic * 1e-5 * sigma * sigma).exp()
}

fn below(sigma: f64, tau: f64) -> f64 {
    let tangent = sigma.to_radians().sin() / sigma.to_radians().cos().max(1e-12);
    let beta = (tangent * (1.0 + 0.3225 * tau.to_radians().cos().powi(2)).sqrt()).atan().to_degrees();
    (6.49e-3 * beta + 21e-5 * beta * beta).exp()
}

/// R, the distance from the line of sight over the distance ahead, is tan σ.
fn iwata(sigma: f64) -> f64 {
    let r = sigma.to_radians().sin() / sigma.to_radians().cos().max(1e-12);
    1.0 + if r < 0.6 { 0.8 } else { 1.2 } * r
}

fn kim(sigma: f64, tau: f64) -> f64 {
    let t = tau;
    let centre = ((-9e-6 * t + 0.0014) * t + 0.0866) * t + 21.633;
    let width = ((-9e-6 * t + 0.0013) * t + 0.0853) * t + 8.772;
    ((sigma - centre) / width).exp()
}

/// Part of the view in which glare sources are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FieldOfView {
    /// All of the picture.
    #[default]
    Whole,
    /// What two eyes see together, after Guth (evalglare's `-G 1`).
    Total,
    /// What both eyes see (evalglare's `-G 2`).
    Binocular,
}

/// Greatest angle from the line of sight seen with both eyes, degrees, at tau = 105, 110, … 180.
/// Read off the pictures `evalglare -g 2` writes; 60 for smaller tau.
const BINOCULAR_BELOW: [f64; 16] =
    [60.0, 59.25, 57.98, 56.61, 55.13, 53.66, 52.50, 52.06, 52.78, 55.04, 58.26, 61.75, 64.58, 66.53, 67.67, 68.20];

impl FieldOfView {
    /// Whether a direction is seen.
    pub fn contains(self, frame: &ViewFrame, direction: [f64; 3]) -> bool {
        if self == Self::Whole {
            return true;
        }
        let (sigma, tau) = angles(frame, direction);
        sigma <= self.limit(tau)
    }

    /// Greatest angle from the line of sight, degrees, in a direction `tau` degrees from upwards.
    pub fn limit(self, tau: f64) -> f64 {
        match self {
            Self::Whole => 180.0,
            Self::Total if tau > 135.0 => {
                let t = 180.0 - tau;
                let curve = -0.014_699_242 + t * (-1.554_110_6e-5 + t * (4.689_806_8e-6 - t * 5.153_968_7e-8));
                -1.0 / curve
            }
            Self::Total => {
                let t = tau;
                (7.745_821_8 + t * (5.740_791_5e-4 + t * (-2.174_631_8e-4 + t * 8.557_272_6e-6))).powi(2)
            }
            Self::Binocular => {
                let place = (tau - 105.0) / 5.0;
                if place <= 0.0 {
                    return 60.0;
                }
                let i = (place as usize).min(BINOCULAR_BELOW.len() - 2);
                let f = (place - i as f64).min(1.0);
                BINOCULAR_BELOW[i] * (1.0 - f) + BINOCULAR_BELOW[i + 1] * f
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame() -> ViewFrame {
        ViewFrame::new([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]).unwrap()
    }

    /// Centre of pixel (x, y from the bottom) of a 400 × 400 equiangular fisheye.
    fn pixel(x: f64, y: f64) -> [f64; 3] {
        let (u, v) = ((x + 0.5) / 400.0 - 0.5, (y + 0.5) / 400.0 - 0.5);
        let (t, p) = (std::f64::consts::PI * u.hypot(v), v.atan2(u));
        [t.sin() * p.cos(), t.cos(), t.sin() * p.sin()]
    }

    #[test]
    fn position_index_is_evalglares() {
        // `evalglare -p -c` on a 400 × 400 fisheye, written as RGBE: 0.4 % per value.
        for ((x, y), expected) in
            [((200, 250), 2.40934), ((127, 246), 2.87295), ((256, 244), 2.43082), ((200, 150), 1.34662), ((137, 141), 1.82938)]
        {
            let p = PositionIndex::Guth.of(&frame(), pixel(f64::from(x), f64::from(y)));
            assert!((p / expected - 1.0).abs() < 0.005, "{x} {y}: {p} instead of {expected}");
        }
        // `evalglare -P 1 -d`, six digits.
        let kim = PositionIndex::Kim.of(&frame(), [-0.526968, 0.779788, 0.337987]);
        assert!((kim - 1.768315).abs() < 1e-4, "{kim}");
        let guth = PositionIndex::Guth.of(&frame(), [-0.526968, 0.779788, 0.337987]);
        assert!((guth - 2.870926).abs() < 1e-4, "{guth}");
    }

    #[test]
    fn position_index_is_finite_and_symmetric_everywhere() {
        for model in [PositionIndex::Guth, PositionIndex::GuthIwata, PositionIndex::Kim] {
            for i in 0..400 {
                for j in 0..200 {
                    let d = pixel(f64::from(i), f64::from(j * 2));
                    let p = model.of(&frame(), d);
                    assert!(p.is_finite() && p > 0.0, "{model:?} {d:?} {p}");
                    let mirrored = model.of(&frame(), [-d[0], d[1], d[2]]);
                    assert!((p - mirrored).abs() <= 1e-9 * p, "{model:?} {d:?}");
                    assert!(model == PositionIndex::Kim || (1.0..=16.0).contains(&p));
                }
            }
            let ahead = model.of(&frame(), [0.0, 1.0, 0.0]);
            assert!(model == PositionIndex::Kim || (ahead - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn field_of_view_limits_are_those_of_evalglares_masks() {
        // Half-way between the last kept and the first cut pixel of `evalglare -g 1`, ± a pixel.
        for (tau, sigma) in [(0.0, 59.9), (30.0, 60.8), (50.0, 68.8), (60.0, 78.2), (140.0, 89.7), (160.0, 73.7), (180.0, 68.0)] {
            let limit = FieldOfView::Total.limit(tau);
            assert!((limit - sigma).abs() < 0.6, "{tau}: {limit} instead of {sigma}");
        }
        assert!(FieldOfView::Total.limit(100.0) > 90.0);
        for tau in 0..=1800 {
            let limit = FieldOfView::Binocular.limit(f64::from(tau) / 10.0);
            assert!((52.0..=68.3).contains(&limit));
        }
    }
}
