//! The mesh of incident directions: a chain of polar angles, or a spherical Delaunay mesh.
//!
//! The stereographic projection maps circles to circles, so the Delaunay mesh of directions is that of their
//! projections onto the plane (Bowyer and Watson).

use super::mirrored;
use glam::{DMat3, DVec3};

/// A distribution, or its image in mirrors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Vertex {
    pub distribution: usize,
    pub mirror: u8,
}

/// Incident directions and what lies between them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Mesh {
    /// By polar angle, all along +x.
    Chain {
        vertices: Vec<Vertex>,
        directions: Vec<DVec3>,
    },
    Triangles {
        vertices: Vec<Vertex>,
        directions: Vec<DVec3>,
        triangles: Vec<[usize; 3]>,
    },
}

/// Where a direction lies.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Place {
    /// Vertices with weights; the weights sum to 1.
    pub corners: Vec<(usize, f64)>,
    /// If the direction is beyond the mesh: the direction on its edge that stands in.
    pub beyond: Option<DVec3>,
}

impl Mesh {
    pub fn chain(vertices: Vec<Vertex>, incident: &[DVec3]) -> Self {
        let directions = vertices.iter().map(|v| incident[v.distribution]).collect();
        Self::Chain { vertices, directions }
    }

    pub fn triangles(vertices: Vec<Vertex>, incident: &[DVec3]) -> Self {
        let directions: Vec<DVec3> = vertices.iter().map(|v| mirrored(incident[v.distribution], v.mirror)).collect();
        let triangles = delaunay(&directions);
        Self::Triangles { vertices, directions, triangles }
    }

    pub fn is_chain(&self) -> bool {
        matches!(self, Self::Chain { .. })
    }

    pub fn vertices(&self) -> &[Vertex] {
        match self {
            Self::Chain { vertices, .. } | Self::Triangles { vertices, .. } => vertices,
        }
    }

    pub fn directions(&self) -> &[DVec3] {
        match self {
            Self::Chain { directions, .. } | Self::Triangles { directions, .. } => directions,
        }
    }

    /// Pairs of vertices that are joined, the smaller index first.
    pub fn edges(&self) -> Vec<[usize; 2]> {
        let mut edges: Vec<[usize; 2]> = match self {
            Self::Chain { vertices, .. } => (1..vertices.len()).map(|k| [k - 1, k]).collect(),
            Self::Triangles { triangles, .. } => {
                triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*a, *c]]).map(|[a, b]| [a.min(b), a.max(b)]).collect()
            }
        };
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    pub fn locate(&self, d: DVec3) -> Place {
        match self {
            Self::Chain { directions, .. } => {
                let angle = |v: DVec3| v.x.hypot(v.y).atan2(v.z);
                let t = angle(d);
                let next = directions.iter().position(|v| angle(*v) > t).unwrap_or(directions.len());
                match next {
                    0 => Place { corners: vec![(0, 1.0)], beyond: Some(directions[0]) },
                    n if n == directions.len() => Place { corners: vec![(n - 1, 1.0)], beyond: Some(directions[n - 1]) },
                    n => {
                        let (low, high) = (angle(directions[n - 1]), angle(directions[n]));
                        let share = (t - low) / (high - low);
                        Place { corners: vec![(n - 1, 1.0 - share), (n, share)], beyond: None }
                    }
                }
            }
            Self::Triangles { directions, triangles, .. } => {
                let mut best: Option<(f64, [usize; 3], DVec3)> = None;
                for triangle in triangles {
                    let [a, b, c] = triangle.map(|v| directions[v]);
                    let m = DMat3::from_cols(a, b, c);
                    let w = m.inverse() * d;
                    let w = w / w.element_sum();
                    // How far outside: a length, so that thin triangles are not preferred.
                    let clamped = w.max(DVec3::ZERO);
                    let clamped = clamped / clamped.element_sum();
                    let inside = if w.min_element() >= -1e-9 { 0.0 } else { ((m * clamped).normalize_or(d) - d).length() };
                    if clamped.is_finite() && best.is_none_or(|(least, ..)| inside < least) {
                        best = Some((inside, *triangle, clamped));
                        if inside == 0.0 {
                            break;
                        }
                    }
                }
                let Some((outside, triangle, w)) = best else {
                    return Place { corners: vec![(0, 1.0)], beyond: Some(directions[0]) };
                };
                let from = (w.x * directions[triangle[0]] + w.y * directions[triangle[1]] + w.z * directions[triangle[2]]).normalize_or(d);
                Place { corners: triangle.into_iter().zip(w.to_array()).collect(), beyond: (outside > 1e-6).then_some(from) }
            }
        }
    }
}

/// Triangles of the Delaunay mesh of directions with z ≥ 0.
fn delaunay(directions: &[DVec3]) -> Vec<[usize; 3]> {
    let n = directions.len();
    // Regular grids have many points on one circle: tiny shifts decide for one of the meshes.
    let shift = |k: usize| {
        let mut random = crate::random::Random(k as u64);
        [1e-7 * (random.next() - 0.5), 1e-7 * (random.next() - 0.5)]
    };
    let mut points: Vec<[f64; 2]> = directions
        .iter()
        .enumerate()
        .map(|(k, d)| {
            let [a, b] = shift(k);
            [d.x / (1.0 + d.z) + a, d.y / (1.0 + d.z) + b]
        })
        .collect();
    points.extend([[-1e4, -1e4], [1e4, -1e4], [0.0, 1e4]]);
    let mut triangles = vec![[n, n + 1, n + 2]];
    for k in 0..n {
        let (broken, kept): (Vec<_>, Vec<_>) = triangles.into_iter().partition(|t| in_circle(t.map(|v| points[v]), points[k]));
        triangles = kept;
        let sides = || broken.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
        for [a, b] in sides().filter(|[a, b]| !sides().any(|s| s == [*b, *a])) {
            triangles.push([a, b, k]);
        }
    }
    triangles.retain(|t| t.iter().all(|v| *v < n) && area(t.map(|v| points[v])) > 1e-6);
    triangles
}

/// Twice the area, positive counter-clockwise.
fn area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn in_circle([a, b, c]: [[f64; 2]; 3], p: [f64; 2]) -> bool {
    let row = |q: [f64; 2]| {
        let (x, y) = (q[0] - p[0], q[1] - p[1]);
        DVec3::new(x, y, x * x + y * y)
    };
    DMat3::from_cols(row(a), row(b), row(c)).determinant() > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_of_directions_is_covered_once_and_weights_give_the_direction_back() {
        let mut incident = vec![DVec3::Z];
        for theta in [20.0f64, 40.0, 60.0, 80.0] {
            for k in 0..12 {
                let ((s, c), (y, x)) = (theta.to_radians().sin_cos(), (std::f64::consts::TAU * f64::from(k) / 12.0).sin_cos());
                incident.push(DVec3::new(s * x, s * y, c));
            }
        }
        let vertices: Vec<Vertex> = (0..incident.len()).map(|distribution| Vertex { distribution, mirror: 0 }).collect();
        let mesh = Mesh::triangles(vertices, &incident);
        let Mesh::Triangles { triangles, .. } = &mesh else { unreachable!() };
        // Euler: a triangulation of v points of which h are on the hull has 2v − h − 2 triangles.
        assert_eq!(triangles.len(), 2 * 49 - 12 - 2);
        for k in 0..500 {
            let mut random = crate::random::Random(k);
            let (r, phi) = (0.95 * random.next().sqrt(), std::f64::consts::TAU * random.next());
            let d = DVec3::new(r * phi.cos(), r * phi.sin(), (1.0 - r * r).sqrt());
            let place = mesh.locate(d);
            let back: DVec3 = place.corners.iter().map(|(v, w)| *w * incident[*v]).sum();
            assert!((back.normalize() - d).length() < 1e-6, "{d} {back}");
            assert!((place.corners.iter().map(|c| c.1).sum::<f64>() - 1.0).abs() < 1e-9 && place.beyond.is_none());
        }
        let grazing = mesh.locate(DVec3::new(1.0, 0.0, 0.0));
        assert!(grazing.beyond.unwrap().distance(incident[37]) < 0.02, "{grazing:?}");
    }
}
