//! Matrices for the tests of this module.

use super::{CONSTRAINED, SymmetricMatrix};

/// The five-point Laplacian on `n x n` interior points with zero boundary values, plus `shift`
/// times the identity.
pub fn laplacian(n: usize, shift: f64) -> SymmetricMatrix {
    let at = |i: usize, j: usize| (i + n * j) as u32;
    let mut edges = Vec::new();
    for j in 0..n {
        for i in 0..n {
            // One half of the links to the boundary and all links to the right and upwards.
            edges.push([at(i, j), if i + 1 < n { at(i + 1, j) } else { CONSTRAINED }]);
            edges.push([at(i, j), if j + 1 < n { at(i, j + 1) } else { CONSTRAINED }]);
            if i == 0 {
                edges.push([CONSTRAINED, at(i, j)]);
            }
            if j == 0 {
                edges.push([CONSTRAINED, at(i, j)]);
            }
        }
    }
    let mut matrix = SymmetricMatrix::from_groups(n * n, edges.iter()).unwrap();
    for edge in &edges {
        matrix.add_group(edge, &[1.0, -1.0, -1.0, 1.0]).unwrap();
    }
    for i in 0..n * n {
        matrix.add_group(&[i as u32], &[shift]).unwrap();
    }
    matrix
}

/// A Stokes step in the unit square, P2-P1 on `n x n` squares cut in two, zero velocity on the
/// walls: `mass (u, v) + viscosity (grad u, grad v) - (p, div v) - (q, div u) - penalty (p, q)`.
/// Without penalty the first pressure is fixed. Returns the matrix and the number of the first
/// pressure.
pub fn stokes(n: usize, mass: f64, viscosity: f64, penalty: f64) -> (SymmetricMatrix, usize) {
    let fixed = usize::from(penalty == 0.0);
    let inner = 2 * n - 1;
    // Nodes have the integer coordinates 0..=2n; vertices are those with two even ones.
    let velocity = |[i, j]: [usize; 2], component: usize| match (1..2 * n).contains(&i)
        && (1..2 * n).contains(&j)
    {
        true => (component * inner * inner + i - 1 + (j - 1) * inner) as u32,
        false => CONSTRAINED,
    };
    let pressure = |[i, j]: [usize; 2]| match i / 2 + j / 2 * (n + 1) {
        k if k < fixed => CONSTRAINED,
        k => (2 * inner * inner + k - fixed) as u32,
    };
    let mut cells = Vec::new();
    for (i, j) in (0..n * n).map(|k| (2 * (k % n), 2 * (k / n))) {
        for corners in [[[i, j], [i + 2, j], [i + 2, j + 2]], [[i, j], [i + 2, j + 2], [i, j + 2]]]
        {
            let middle = |a: usize, b: usize| [0, 1].map(|c| (corners[a][c] + corners[b][c]) / 2);
            let nodes =
                [corners[0], corners[1], corners[2], middle(1, 2), middle(2, 0), middle(0, 1)];
            let mut unknowns: Vec<u32> =
                (0..2).flat_map(|c| nodes.map(|node| velocity(node, c))).collect();
            unknowns.extend(corners.map(pressure));
            let points = corners.map(|corner| corner.map(|c| c as f64 / (2 * n) as f64));
            cells.push((unknowns, stokes_cell(points, mass, viscosity, penalty)));
        }
    }
    let order = 2 * inner * inner + (n + 1) * (n + 1) - fixed;
    let mut matrix =
        SymmetricMatrix::from_groups(order, cells.iter().map(|(unknowns, _)| unknowns)).unwrap();
    for (unknowns, local) in &cells {
        matrix.add_group(unknowns, local).unwrap();
    }
    (matrix, 2 * inner * inner)
}

/// The 15 x 15 matrix of one triangle: six nodes of the first velocity component, six of the
/// second, three pressures.
fn stokes_cell(x: [[f64; 2]; 3], mass: f64, viscosity: f64, penalty: f64) -> Vec<f64> {
    let edge = |a: usize, b: usize, c: usize| x[b][c] - x[a][c];
    let twice_area = edge(0, 1, 0) * edge(0, 2, 1) - edge(0, 1, 1) * edge(0, 2, 0);
    let slope = [(1, 2), (2, 0), (0, 1)]
        .map(|(a, b)| [-edge(a, b, 1) / twice_area, edge(a, b, 0) / twice_area]);
    let mut local = vec![0.0; 225];
    // The rule of degree 4 with six points (Dunavant 1985).
    for (a, weight) in
        [(0.445948490915965, 0.223381589678011), (0.091576213509771, 0.109951743655322)]
    {
        for special in 0..3 {
            let mut l = [a; 3];
            l[special] = 1.0 - 2.0 * a;
            let w = 0.5 * twice_area * weight;
            let (mut value, mut gradient) = ([0.0; 6], [[0.0; 2]; 6]);
            for k in 0..3 {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                value[k] = l[k] * (2.0 * l[k] - 1.0);
                value[k + 3] = 4.0 * l[i] * l[j];
                gradient[k] = slope[k].map(|s| (4.0 * l[k] - 1.0) * s);
                gradient[k + 3] = [0, 1].map(|c| 4.0 * (l[i] * slope[j][c] + l[j] * slope[i][c]));
            }
            for r in 0..6 {
                for c in 0..2 {
                    for s in 0..6 {
                        let stiffness =
                            gradient[r][0] * gradient[s][0] + gradient[r][1] * gradient[s][1];
                        local[(6 * c + r) * 15 + 6 * c + s] +=
                            w * (mass * value[r] * value[s] + viscosity * stiffness);
                    }
                    for q in 0..3 {
                        local[(6 * c + r) * 15 + 12 + q] -= w * l[q] * gradient[r][c];
                        local[(12 + q) * 15 + 6 * c + r] -= w * l[q] * gradient[r][c];
                    }
                }
            }
            for (q, r) in (0..9).map(|k| (k / 3, k % 3)) {
                local[(12 + q) * 15 + 12 + r] -= w * penalty * l[q] * l[r];
            }
        }
    }
    local
}

/// Numbers in [-0.5, 0.5) that look random and are always the same.
pub fn scattered(count: usize) -> Vec<f64> {
    (0..count).map(|k| ((k as f64 + 1.0) * 0.618_033_988_749_895).fract() - 0.5).collect()
}
