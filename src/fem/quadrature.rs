//! Quadrature on simplices, exact for polynomials up to a given degree.

/// A rule: points in barycentric coordinates (entries `0..=D`) and weights with sum 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Rule {
    /// Barycentric coordinates of the points.
    pub points: Vec<[f64; 4]>,
    /// Weights, as fractions of the cell.
    pub weights: Vec<f64>,
}

impl Rule {
    /// A rule on a simplex of dimension `d` (1, 2 or 3), exact to `degree`: the symmetric rules of
    /// Strang and Fix (1973), Radon and Dunavant (1985) on triangles, those of Keast (1986) and
    /// Walkington (2000) on tetrahedra, if there is one of this degree, otherwise products of Gauss
    /// points.
    pub fn simplex(d: usize, degree: usize) -> Rule {
        let symmetric = match d {
            2 => symmetric_triangle(degree),
            3 => symmetric_tetrahedron(degree),
            _ => None,
        };
        symmetric.unwrap_or_else(|| collapsed_gauss(d, degree))
    }
    /// Number of points.
    pub fn len(&self) -> usize {
        self.weights.len()
    }
    /// True if there are no points (never, for a rule of this module).
    pub fn is_empty(&self) -> bool {
        self.weights.is_empty()
    }
}

/// An orbit of a symmetric rule: weight of each point, and two of its barycentric coordinates.
type Orbit = (f64, f64, f64);

const DEGREE_2: &[Orbit] = &[(1.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0)];
const DEGREE_4: &[Orbit] = &[
    (0.223381589678011, 0.445948490915965, 0.445948490915965),
    (0.109951743655322, 0.091576213509771, 0.091576213509771),
];
const DEGREE_6: &[Orbit] = &[
    (0.116786275726379, 0.249286745170910, 0.249286745170910),
    (0.050844906370207, 0.063089014491502, 0.063089014491502),
    (0.082851075618374, 0.053145049844817, 0.310352451033784),
];
const DEGREE_8: &[Orbit] = &[
    (0.144315607677787, 1.0 / 3.0, 1.0 / 3.0),
    (0.095091634267285, 0.459292588292723, 0.459292588292723),
    (0.103217370534718, 0.170569307751760, 0.170569307751760),
    (0.032458497623198, 0.050547228317031, 0.050547228317031),
    (0.027230314174435, 0.008394777409958, 0.263112829634638),
];

fn symmetric_triangle(degree: usize) -> Option<Rule> {
    // Radon's seven points have closed forms.
    let r = 15f64.sqrt();
    let degree_5 = [
        (0.225, 1.0 / 3.0, 1.0 / 3.0),
        ((155.0 - r) / 1200.0, (6.0 - r) / 21.0, (6.0 - r) / 21.0),
        ((155.0 + r) / 1200.0, (6.0 + r) / 21.0, (6.0 + r) / 21.0),
    ];
    let orbits: &[Orbit] = match degree {
        0 | 1 => &[(1.0, 1.0 / 3.0, 1.0 / 3.0)],
        2 => DEGREE_2,
        3 | 4 => DEGREE_4,
        5 => &degree_5,
        6 => DEGREE_6,
        7 | 8 => DEGREE_8,
        _ => return None,
    };
    let mut rule = Rule { points: Vec::new(), weights: Vec::new() };
    for &(w, a, b) in orbits {
        let c = 1.0 - a - b;
        let mut points: Vec<[f64; 4]> = vec![
            [a, b, c, 0.],
            [b, c, a, 0.],
            [c, a, b, 0.],
            [b, a, c, 0.],
            [a, c, b, 0.],
            [c, b, a, 0.],
        ];
        if (a - b).abs() < 1e-12 {
            points.truncate(if (a - c).abs() < 1e-12 { 1 } else { 3 });
        }
        rule.weights.extend(points.iter().map(|_| w));
        rule.points.extend(points);
    }
    let total: f64 = rule.weights.iter().sum();
    rule.weights.iter_mut().for_each(|w| *w /= total);
    Some(rule)
}

/// Orbits of points `(a, a, b, 1 - 2 a - b)` and their permutations.
const TETRAHEDRON_2: &[Orbit] = &[(0.25, 0.138_196_601_125_010_5, 0.138_196_601_125_010_5)];
const TETRAHEDRON_5: &[Orbit] = &[
    (0.112_687_925_718_015_85, 0.310_885_919_263_300_6, 0.310_885_919_263_300_6),
    (0.073_493_043_116_361_96, 0.092_735_250_310_891_22, 0.092_735_250_310_891_22),
    (0.042_546_020_777_081_466, 0.045_503_704_125_649_65, 0.454_496_295_874_350_36),
];
const TETRAHEDRON_6: &[Orbit] = &[
    (0.03992275025816787, 0.214_602_871_259_151_67, 0.214_602_871_259_151_67),
    (0.010077211055320657, 0.040_673_958_534_611_34, 0.040_673_958_534_611_34),
    (0.055_357_181_543_654_39, 0.322_337_890_142_275_65, 0.322_337_890_142_275_65),
    (0.048214285714285695, 0.063_661_001_875_017_53, 0.269_672_331_458_315_9),
];

fn symmetric_tetrahedron(degree: usize) -> Option<Rule> {
    let orbits = match degree {
        0 | 1 => return Some(Rule { points: vec![[0.25; 4]], weights: vec![1.0] }),
        2 => TETRAHEDRON_2,
        3..=5 => TETRAHEDRON_5,
        6 => TETRAHEDRON_6,
        _ => return None,
    };
    let mut rule = Rule { points: Vec::new(), weights: Vec::new() };
    for &(w, a, b) in orbits {
        let values = [a, a, b, 1.0 - 2.0 * a - b];
        let mut points: Vec<[f64; 4]> = Vec::new();
        for code in 0..256usize {
            let index = [code % 4, code / 4 % 4, code / 16 % 4, code / 64];
            let point = index.map(|k| values[k]);
            let same = |p: &[f64; 4]| p.iter().zip(&point).all(|(x, y)| (x - y).abs() < 1e-12);
            if (0..4).all(|k| index.contains(&k)) && !points.iter().any(same) {
                points.push(point);
            }
        }
        rule.weights.extend(points.iter().map(|_| w));
        rule.points.extend(points);
    }
    let total: f64 = rule.weights.iter().sum();
    rule.weights.iter_mut().for_each(|w| *w /= total);
    Some(rule)
}

/// Product of Gauss-Legendre rules under the collapse of the cube onto the simplex.
fn collapsed_gauss(d: usize, degree: usize) -> Rule {
    let n = (degree + d).div_ceil(2).max(1);
    let gauss = gauss_legendre(n);
    let mut rule = Rule { points: Vec::new(), weights: Vec::new() };
    for index in 0..n.pow(d as u32) {
        let (mut rest, mut weight, mut k) = (1.0_f64, 1.0, index);
        let mut l = [0.0; 4];
        for axis in 1..=d {
            let (x, w) = gauss[k % n];
            k /= n;
            l[axis] = x * rest;
            // Jacobian of the collapse, times the factorial that normalises the volume.
            weight *= w * axis as f64 * if axis > 1 { rest } else { 1.0 };
            rest -= l[axis];
        }
        l[0] = rest;
        rule.points.push(l);
        rule.weights.push(weight);
    }
    rule
}

/// Points and weights of the Gauss-Legendre rule with `n` points on `[0, 1]`, by Newton's method on
/// the Legendre polynomial.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut derivative = 1.0;
            for _ in 0..100 {
                let (mut p0, mut p1) = (1.0, x);
                for k in 2..=n {
                    let k = k as f64;
                    (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
                }
                derivative = n as f64 * (x * p1 - p0) / (x * x - 1.0);
                let step = p1 / derivative;
                x -= step;
                if step.abs() < 1e-15 {
                    break;
                }
            }
            (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * derivative * derivative))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factorial(n: usize) -> f64 {
        (1..=n).map(|k| k as f64).product()
    }

    #[test]
    fn rules_integrate_all_monomials_of_their_degree() {
        for d in 1..=3 {
            for degree in 0..=11 {
                let rule = Rule::simplex(d, degree);
                for e in 0..(degree + 1).pow(3) {
                    let e = [
                        e % (degree + 1),
                        (e / (degree + 1)) % (degree + 1),
                        e / (degree + 1).pow(2),
                    ];
                    let used = &e[..d];
                    if used.iter().sum::<usize>() > degree || e[d..].iter().any(|&k| k > 0) {
                        continue;
                    }
                    let sum: f64 = rule
                        .points
                        .iter()
                        .zip(&rule.weights)
                        .map(|(l, w)| {
                            w * (0..d).map(|k| l[k + 1].powi(used[k] as i32)).product::<f64>()
                        })
                        .sum();
                    let exact = factorial(d) * used.iter().map(|&k| factorial(k)).product::<f64>()
                        / factorial(d + used.iter().sum::<usize>());
                    assert!(
                        (sum - exact).abs() < 1e-14,
                        "d {d} degree {degree} {used:?}: {sum} {exact}"
                    );
                }
            }
        }
    }
}
