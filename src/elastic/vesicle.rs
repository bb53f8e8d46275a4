//! The membrane of a vesicle: it bends, and its length (in space: its area) does not change.

use super::area_law::AreaLaw;
use super::cut_surface::{CutSurface, Points};
use super::sharp_shear::SharpShearMembrane;
use super::surface_law::{ShearLaw, SurfaceLaw};
use crate::base::{Cause, Error, Result};
use crate::fem::{
    At, Basis, Element, MAX_LOCAL, Numbering, Rule as Quadrature, Space, SurfacePoint, VectorForm,
};
use crate::flow::block::Block;
use crate::flow::term::MomentumTerm;
use crate::levelset::{Interface, curvature_vector, extents, normal_vector, origins, second_form};
use crate::mesh::{Location, NONE, Point};
use crate::structure::{
    Carry, Data, Declaration, FieldId, Fields, Host, ImmersedInterface, InterfaceForce, Medium,
    Moved, Place, Rule, SurfaceStrain, Velocity, follow_markers,
};
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// Weight of the normal derivative of the tension over the cut cells, over the inverse viscosity.
const TENSION_ACROSS: f64 = 0.1;
/// Weight of that of the moment, in diameters of cells.
const MOMENT_ACROSS: f64 = 0.07;
/// Layers of cells about the cut ones whose unknowns are in the matrix, so that its pattern lasts
/// until the interface leaves them.
const LAYERS: usize = 2;

/// The membrane of a vesicle (3.2.4): the energy `E = int_S k/2 (H - c)^2 ds` of Helfrich, `H` the
/// sum of the principal curvatures, positive on spheres, and no change of its length (area)
/// anywhere.
///
/// Unknowns of a step are the velocity `u`, the pressure, and on the interface `S` the tension
/// `sigma` (P1 traces), the moment `m = k (H - c)` (P2 traces) and the jump `P` of the pressure.
/// With the projection `P_S` and the second fundamental form `II`,
///
/// ```text
/// a(u, v) - (p, div v) + int sigma P_S : grad v + K(m, v) + P int n . v = F(v)
/// int q P_S : grad u - s(sigma, q)               = - int q ln(L/L_0)/dt
/// K(q, u) - 1/(k dt) [int m q + s'(m, q)]        = - 1/dt int (H* - c) q
/// int u . n                                      = (A_0 - A)/dt
/// K(q, v) = int [ (grad_S q) . (grad v)^T n - q II : grad v ].
/// ```
///
/// The third row is the curvature at the end of the step: that of a material point changes at the
/// rate `-K`. So force and curvature are adjoint, the force is minus the derivative of the energy
/// but for a tension, which `sigma` contains, and the scheme is stable for steps far beyond the
/// limit of an explicit force, of the order of `mu h^3/k`. `S` is the interface predicted
/// for the end of the step, and `H*` the curvature at its start, at the place where the material
/// comes from (in the first step, which predicts nothing, both are those at the start). The measured
/// area `A` and length `L` bring those at rest back, which finite steps change. `s` and `s'` are
/// products of normal derivatives over the cut cells. In the plane `q II : grad v` is a tension, and
/// is left out; the spontaneous curvature `c` then has no effect, for the integral of the curvature
/// of a closed curve does not change.
#[derive(Clone)]
pub struct Vesicle<const D: usize> {
    bending: f64,
    spontaneous: f64,
    viscosity: f64,
    /// Resistance to shear, in space.
    shear: Option<SharpShearMembrane<D>>,
    /// What [`Motion`] has, in its order.
    motion: FieldId,
    /// A point of the membrane that moves with it.
    marker: FieldId,
    /// Cells whose unknowns the matrix has: part of the state, so that a resumed run has the same
    /// matrices.
    ring: FieldId,
    /// One number per node, equal for nodes that periodic sides identify.
    identified: Arc<[u32]>,
    cuts: CutSurface<D>,
    curved: Option<Curved<D>>,
    /// The interface that is predicted for the end of a step.
    ahead: Option<Bent<D>>,
    system: System<D>,
}

/// Change of length or area that is told: rows of the system keep them to 1e-4 and less, but for
/// the first steps of a form far from rest.
const LOST: f64 = 3e-3;
/// Curvature times the diameter of the cell that is told.
const SHARPEST: f64 = 1.5;

/// Name of the field of [`Motion`].
const MOTION: &str = "motion";

/// Size at rest, and how far a vesicle of the plane and its membrane have turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Enclosed area (volume) at rest.
    pub enclosed: f64,
    /// Length (area) at rest.
    pub own: f64,
    /// Angle of the long axis in degrees, counted on over turns.
    pub turned: f64,
    /// Direction of a point of the membrane from the centre in degrees, counted on over turns.
    pub treaded: f64,
}

impl Default for Motion {
    fn default() -> Motion {
        let nan = f64::NAN;
        Motion { enclosed: nan, own: nan, turned: nan, treaded: nan }
    }
}

impl Motion {
    fn to_list(self) -> [f64; 4] {
        [self.enclosed, self.own, self.turned, self.treaded]
    }
    fn of<const D: usize>(fields: &Fields<D>, id: FieldId) -> Result<Motion> {
        match *fields.scalar(id) {
            [enclosed, own, turned, treaded] => Ok(Motion { enclosed, own, turned, treaded }),
            _ => Err(Error::internal("the size of a vesicle at rest is missing")),
        }
    }
    /// That of the vesicle of this name.
    pub fn of_vesicle<const D: usize>(fields: &Fields<D>, name: &str) -> Option<Motion> {
        Motion::of(fields, fields.find(&format!("{name}.{MOTION}"))?).ok()
    }
}

/// Direction of a vector of the plane in degrees.
fn direction<const D: usize>(v: &SVector<f64, D>) -> f64 {
    v[1].atan2(v[0]).to_degrees()
}

/// The angle nearest to `last` that differs from `angle` by whole turns of `turn` degrees.
fn counted_on(last: f64, angle: f64, turn: f64) -> f64 {
    angle + turn * ((last - angle) / turn).round()
}

/// An interface with its curvature.
#[derive(Clone)]
struct Curved<const D: usize> {
    phi: Vec<f64>,
    points: Points<D>,
    /// The curvature vector at the nodes of cut cells, and `H` at the points.
    vectors: Vec<SVector<f64, D>>,
    curvature: Vec<f64>,
}

/// An interface on which forces act, with the curvature that its material has at the start of the
/// step.
#[derive(Clone)]
struct Bent<const D: usize> {
    phi: Vec<f64>,
    points: Points<D>,
    curvature: Vec<f64>,
}

impl<const D: usize> Vesicle<D> {
    /// A membrane with this bending modulus (an energy; in the plane per unit depth, times a
    /// length) and spontaneous curvature, in a fluid of this viscosity (between two fluids, their
    /// mean).
    pub fn new(bending: f64, spontaneous: f64, viscosity: f64) -> Vesicle<D> {
        Vesicle {
            bending,
            spontaneous,
            viscosity,
            shear: None,
            motion: FieldId::default(),
            marker: FieldId::default(),
            ring: FieldId::default(),
            identified: Arc::default(),
            cuts: CutSurface::default(),
            curved: None,
            ahead: None,
            system: System::default(),
        }
    }

    /// The same with resistance to shear: the membrane of a red blood cell.
    pub fn with_shear(self, shear: ShearLaw) -> Vesicle<D> {
        let law = SurfaceLaw::Split { area: AreaLaw::Tension { tension: 0.0 }, shear };
        let shear = Some(SharpShearMembrane::new(law, self.viscosity));
        Vesicle { shear, ..self }
    }

    /// The interface of `phi` with its curvature.
    fn curved(&mut self, space: &Space<D>, phi: &[f64]) -> Result<&Curved<D>> {
        if self.curved.as_ref().is_none_or(|c| c.phi != phi) {
            let points = self.cuts.of(space, phi)?;
            let (on, of) = ((space, &self.identified[..]), (&points[..], phi));
            let vectors = curvature_vector(on, of)?;
            let at = |p: &SurfacePoint<D>| {
                space.value(&vectors, p.at.cell, &p.at.barycentric).dot(&p.normal)
            };
            let curvature = points.iter().map(at).collect();
            self.curved = Some(Curved { phi: phi.to_vec(), points, vectors, curvature });
        }
        self.curved.as_ref().ok_or_else(|| Error::internal("no curvature was found"))
    }

    /// Keeps the cells of the unknowns as long as the interface is in them.
    fn keep_ring(&self, by: &Moved<'_, D>, points: &[SurfacePoint<D>], fields: &mut Fields<D>) {
        let (space, cut) = (by.carrier.tracer.space(), cut_cells(points));
        let cells = match holds(&self.system.cells, &cut) {
            true => self.system.cells.clone(),
            false => about(space, &self.identified, &cut),
        };
        let labels = fields.labels_mut(self.ring);
        labels.fill(0);
        cells.iter().for_each(|&c| labels[c as usize] = 1);
    }

    /// Follows the long axis and the point of the membrane.
    fn turn(
        &mut self,
        of: &ImmersedInterface<D>,
        by: &Moved<'_, D>,
        ends: [&[SVector<f64, D>]; 2],
        fields: &mut Fields<D>,
    ) -> Result<()> {
        let tracer = &by.carrier.tracer;
        let (space, u) = (tracer.space(), ends[1]);
        let mut motion = Motion::of(fields, self.motion)?;
        let phi = fields.scalar(of.level_set());
        let interface = Interface::cut(space, phi)?;
        let measures = interface.measures().filter(|_| !interface.is_open());
        let mut points = fields.vector(self.marker).to_vec();
        let steps = (tracer.courant(u, by.dt).ceil() as usize).clamp(1, 100);
        follow_markers(&mut points, tracer, ends, by.dt, steps);
        // Back onto the interface, which it leaves by what its path errs.
        for x in &mut points {
            let Some(at) = tracer.locate(x) else { continue };
            let (cell, l) = (at.cell as usize, &at.barycentric);
            let slope = space.gradient(phi, cell, l);
            *x -= slope * (space.value(phi, cell, l) / slope.norm_squared());
        }
        if let (Some(m), [x]) = (measures, &points[..]) {
            motion.turned = counted_on(motion.turned, m.angle.unwrap_or(f64::NAN), 180.0);
            motion.treaded = counted_on(motion.treaded, direction(&(x - m.centroid)), 360.0);
        }
        fields.scalar_mut(self.motion).copy_from_slice(&motion.to_list());
        fields.vector_mut(self.marker).copy_from_slice(&points);
        Ok(())
    }
}

impl<const D: usize> InterfaceForce<D> for Vesicle<D> {
    fn begin(
        &mut self,
        of: &ImmersedInterface<D>,
        host: &Host<'_, D>,
        fields: &mut Declaration<'_, D>,
    ) -> Result<()> {
        self.identified = Numbering::scalar_unknowns(host.space, host.translations).0.into();
        (self.curved, self.ahead, self.system) = (None, None, System::default());
        let (mut motion, mut marker) = (Motion::default(), Point::<D>::repeat(f64::NAN));
        // On a later mesh these are known already.
        if of.phi.len() == host.space.len() {
            let interface = Interface::cut(host.space, &of.phi[..])?;
            let first = interface.points().first().map(|p| p.at.x);
            marker = first.unwrap_or(marker);
            if let Some(m) = interface.measures() {
                [motion.enclosed, motion.own] = [m.enclosed, m.own];
                motion.turned = m.angle.unwrap_or(f64::NAN);
                motion.treaded = direction(&(marker - m.centroid));
            }
        }
        if let Some(shear) = &mut self.shear {
            shear.begin(of, host, fields)?;
        }
        let rule = Rule { carry: Carry::ByOwner, acts: false, written: false };
        let numbers = motion.to_list().to_vec();
        self.motion = fields.add(&of.field_name(MOTION), rule.clone(), || Data::Numbers(numbers));
        let marker = || Data::Points(vec![marker]);
        self.marker = fields.add(&of.field_name("marker"), rule.clone(), marker);
        // Cells of another mesh are none of this one.
        let ring = format!("ring of {}", host.space.mesh().cell_count());
        self.ring = fields.add(&of.field_name(&ring), rule, || {
            Data::Labels(vec![0; host.space.mesh().cell_count()])
        });
        Ok(())
    }
    fn term(&self) -> Option<&dyn MomentumTerm<D>> {
        self.shear.as_ref().and_then(InterfaceForce::term)
    }
    fn block(&self) -> Option<&dyn Block<D>> {
        Some(&self.system)
    }
    fn prepare(&mut self, of: &ImmersedInterface<D>, at: &Place<'_, D>) -> Result<()> {
        if let Some(shear) = &mut self.shear {
            shear.prepare(of, at)?;
        }
        let Some(dt) = at.step else { return Ok(()) };
        let (phi, space) = (at.fields.scalar(of.level_set()), at.space);
        let start = at.drift.map_or(at.fields, |[start, _]| start);
        let [enclosed, own] = extents(space, start.scalar(of.level_set()))?;
        let rest = Motion::of(at.fields, self.motion)?;
        let (spontaneous, bending, viscosity) = (self.spontaneous, self.bending, self.viscosity);
        let mut system = std::mem::take(&mut self.system);
        let identified = Arc::clone(&self.identified);
        let bent = match self.ahead.take().filter(|bent| bent.phi == phi) {
            Some(bent) => bent,
            None => {
                let Curved { phi, points, curvature, .. } = self.curved(space, phi)?.clone();
                Bent { phi, points, curvature }
            }
        };
        let forms = match D {
            2 => Vec::new(),
            _ => {
                let normals = normal_vector((space, &identified), (&bent.points, phi))?;
                bent.points.iter().map(|p| second_form(space, &normals, p)).collect()
            }
        };
        let length: f64 = bent.points.iter().map(|p| p.at.weight).sum();
        system.rates = Rates {
            softness: 1.0 / (bending * dt),
            rate: 1.0 / dt,
            stretching: -(own / rest.own).ln() / dt,
            swelling: (rest.enclosed - enclosed) / (length * dt),
        };
        system.ring(space, &identified, &bent.points, at.fields.labels(self.ring));
        system.place(space, &bent, &forms, (spontaneous, viscosity));
        self.system = system;
        Ok(())
    }
    /// Finds the curvature at the start of the step where the points of the predicted interface come
    /// from.
    fn advance(
        &mut self,
        of: &ImmersedInterface<D>,
        by: &mut Moved<'_, D>,
        fields: &mut Fields<D>,
    ) -> Result<()> {
        if let Some(shear) = &mut self.shear {
            shear.advance(of, by, fields)?;
        }
        let Velocity::Computed { mean, ends } = by.velocity else { return Ok(()) };
        if !by.ahead {
            let space = by.carrier.tracer.space();
            let after = self.cuts.of(space, fields.scalar(of.level_set()))?;
            self.keep_ring(by, &after, fields);
            return if D == 2 { self.turn(of, by, ends, fields) } else { Ok(()) };
        }
        let tracer = &by.carrier.tracer;
        let space = tracer.space();
        let (start, phi) = (by.before.scalar(of.level_set()), fields.scalar(of.level_set()));
        let points = self.cuts.of(space, phi)?;
        let curved = self.curved(space, start)?;
        let from = origins(tracer, (mean, by.dt), &curved.points, &points);
        let curvature = |at: &Location| {
            let (cell, l) = (at.cell as usize, &at.barycentric);
            let normal = space.gradient(start, cell, l).normalize();
            space.value(&curved.vectors, cell, l).dot(&normal)
        };
        let curvature = from.iter().map(curvature).collect();
        self.ahead = Some(Bent { phi: phi.to_vec(), points, curvature });
        Ok(())
    }
    fn energy(
        &mut self,
        of: &ImmersedInterface<D>,
        at: &Place<'_, D>,
        rule: &Basis<D>,
    ) -> Result<f64> {
        let sheared = match &mut self.shear {
            Some(shear) => InterfaceForce::energy(shear, of, at, rule)?,
            None => 0.0,
        };
        let (bending, spontaneous) = (self.bending, self.spontaneous);
        let curved = self.curved(at.space, at.fields.scalar(of.level_set()))?;
        let bent = curved.points.iter().zip(&curved.curvature);
        let of_point = |(p, h): (&SurfacePoint<D>, &f64)| {
            0.5 * bending * p.at.weight * (h - spontaneous).powi(2)
        };
        Ok(sheared + bent.map(of_point).sum::<f64>())
    }
    fn dissipation(&self) -> f64 {
        self.shear.as_ref().map_or(0.0, InterfaceForce::dissipation)
    }
    fn tension(&self) -> f64 {
        self.shear.as_ref().map_or(0.0, InterfaceForce::tension)
    }
    fn step_limit(&self, medium: &Medium) -> f64 {
        self.shear.as_ref().map_or(f64::INFINITY, |s| InterfaceForce::step_limit(s, medium))
    }
    fn carries_strain(&self) -> bool {
        self.shear.is_some()
    }
    fn strain_at(
        &self,
        space: &Space<D>,
        fields: &Fields<D>,
        point: &SurfacePoint<D>,
    ) -> Option<SurfaceStrain<D>> {
        self.shear.as_ref()?.strain_at(space, fields, point)
    }
    fn check_order(&self, order: usize) -> Result<()> {
        if order == 2 {
            return Ok(());
        }
        // At order 1 the angle of a vesicle in shear was 1.7 degrees off in steps of .1 over the rate.
        Err(Error::scene("the bending of a vesicle is of order 2 in time")
            .value(format!("order {order}"))
            .remedy("leave out time.order, or write time.order = 2")
            .because(Cause::FirstOrder))
    }
    fn distrust(
        &self,
        of: &ImmersedInterface<D>,
        space: &Space<D>,
        fields: &Fields<D>,
    ) -> Result<Option<(String, String)>> {
        let (rest, phi) = (Motion::of(fields, self.motion)?, fields.scalar(of.level_set()));
        let [enclosed, own] = extents(space, phi)?;
        let words = if D == 2 { ["area", "length"] } else { ["volume", "area"] };
        let steps = "Take a smaller time.step, or a finer mesh where it goes";
        for (what, change) in
            words.iter().zip([enclosed / rest.enclosed - 1.0, own / rest.own - 1.0])
        {
            if change.abs() > LOST {
                let said =
                    format!("The {what} of `{}` is off by {:+.2} %", of.name, 100.0 * change);
                return Ok(Some((said, steps.into())));
            }
        }
        let Some(curved) = self.curved.as_ref().filter(|c| c.phi == phi) else { return Ok(None) };
        let sharpest = curved.points.iter().zip(&curved.curvature);
        let bent = sharpest.map(|(p, h)| (h.abs() * space.mesh().diameter(p.at.cell), p, h));
        Ok(bent.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|b| b.0 > SHARPEST).map(|(_, p, h)| {
            let said = format!(
                "`{}` has the curvature {h:.3} in a cell of {:.3}, which its mesh does not resolve",
                of.name,
                space.mesh().diameter(p.at.cell)
            );
            (said, steps.into())
        }))
    }
    fn reach(&self, _: &ImmersedInterface<D>) -> f64 {
        0.0
    }
    fn keeps_distance(&self) -> bool {
        true
    }
}

/// The unknowns on the interface, the points of their forms, and the forms.
#[derive(Clone, Default)]
struct System<const D: usize> {
    /// Cells whose unknowns the matrix has, and for each its tensions, moments, and the jump of the
    /// pressure.
    cells: Vec<u32>,
    unknowns: Vec<Vec<u32>>,
    len: usize,
    points: Vec<At<D>>,
    forms: Vec<Form<D>>,
    rates: Rates,
}

/// Numbers of a step.
#[derive(Clone, Copy, Default)]
struct Rates {
    /// `1/(k dt)`.
    softness: f64,
    /// `1/dt`.
    rate: f64,
    /// `-ln(L/L_0)/dt`.
    stretching: f64,
    /// `(A_0 - A)/(L dt)`.
    swelling: f64,
}

/// What is integrated at a point.
#[derive(Clone)]
enum Form<const D: usize> {
    /// A point of the interface.
    Surface(Box<OnSurface<D>>),
    /// A point in a cut cell: normal derivatives of the linear and the quadratic functions, times
    /// the roots of their weights.
    Across { tension: [f64; MAX_LOCAL], moment: [f64; MAX_LOCAL] },
    /// Unknowns that no form has: the bits of their local numbers.
    Idle(u32),
}

/// The forms at a point of the interface.
#[derive(Clone)]
struct OnSurface<const D: usize> {
    barycentric: [f64; 4],
    values: [f64; MAX_LOCAL],
    gradients: [SVector<f64, D>; MAX_LOCAL],
    normal: SVector<f64, D>,
    /// `II` in space, 0 in the plane.
    form: SMatrix<f64, D, D>,
    /// `H* - c`.
    curvature: f64,
}

/// A local unknown.
enum Unknown {
    Tension(usize),
    Moment(usize),
    Jump,
}

impl<const D: usize> System<D> {
    const MOMENTS: usize = (D + 1) * (D + 2) / 2;

    fn local(k: usize) -> Unknown {
        match k {
            k if k <= D => Unknown::Tension(k),
            k if k <= D + Self::MOMENTS => Unknown::Moment(k - D - 1),
            _ => Unknown::Jump,
        }
    }

    /// Takes the cells of label 1 for those of the unknowns if the interface is in them, or else those
    /// about it.
    fn ring(
        &mut self,
        space: &Space<D>,
        identified: &[u32],
        points: &[SurfacePoint<D>],
        known: &[u64],
    ) {
        let cut = cut_cells(points);
        let chosen = known.iter().enumerate().filter(|(_, label)| **label == 1);
        let known: Vec<u32> = chosen.map(|(c, _)| c as u32).collect();
        let cells = if holds(&known, &cut) { known } else { about(space, identified, &cut) };
        if cells != self.cells {
            self.number(space, identified, cells);
        }
    }

    /// Makes the forms for an interface in the cells of the unknowns.
    fn place(
        &mut self,
        space: &Space<D>,
        bent: &Bent<D>,
        forms: &[SMatrix<f64, D, D>],
        (spontaneous, viscosity): (f64, f64),
    ) {
        let groups: Vec<&[SurfacePoint<D>]> =
            bent.points.chunk_by(|a, b| a.at.cell == b.at.cell).collect();
        let cut = cut_cells(&bent.points);
        self.points.clear();
        self.forms.clear();
        let mut used = vec![false; self.len];
        for (i, _) in self.of_cells(&cut) {
            self.unknowns[i].iter().for_each(|&k| used[k as usize] = true);
        }
        let across = Quadrature::simplex(D, 2);
        let mut next = groups.iter().peekable();
        for (i, &cell) in self.cells.iter().enumerate() {
            let c = cell as usize;
            let mesh = space.mesh();
            let corner = mesh.points()[mesh.cell(c)[0] as usize];
            if let Some(group) = next.next_if(|g| g[0].at.cell == c) {
                for p in group.iter() {
                    let inverse = &mesh.map(c).inverse;
                    let g = space.element().reference_gradients::<D>(&p.at.barycentric);
                    let form = OnSurface {
                        barycentric: p.at.barycentric,
                        values: space.element().values::<D>(&p.at.barycentric),
                        gradients: g.map(|g| p.tangential(&inverse.tr_mul(&g))),
                        normal: p.normal,
                        form: forms.get(p.at.q).copied().unwrap_or(SMatrix::zeros()),
                        curvature: bent.curvature[p.at.q] - spontaneous,
                    };
                    self.points.push(At { q: self.points.len(), ..p.at });
                    self.forms.push(Form::Surface(Box::new(form)));
                }
                let (map, size) = (mesh.map(c), mesh.diameter(c));
                let mut middle = [0.0; 4];
                middle[..=D].fill(1.0 / (D as f64 + 1.0));
                let normal = space.gradient(&bent.phi, c, &middle).try_normalize(0.0);
                let normal = normal.unwrap_or(group[0].normal);
                let roots = [(TENSION_ACROSS / viscosity).sqrt(), (MOMENT_ACROSS * size).sqrt()];
                for (l, w) in across.points.iter().zip(&across.weights) {
                    let derivatives = |element: Element, root: f64| {
                        let g = element.reference_gradients::<D>(l);
                        g.map(|g| root * normal.dot(&map.inverse.tr_mul(&g)))
                    };
                    let tension = derivatives(Element::P1, roots[0]);
                    let moment = derivatives(Element::P2, roots[1]);
                    let (q, weight) = (self.points.len(), w * map.volume);
                    self.points.push(At { cell: c, q, barycentric: *l, x: corner, weight });
                    self.forms.push(Form::Across { tension, moment });
                }
            }
            let mut idle = 0;
            for (k, &unknown) in self.unknowns[i].iter().enumerate() {
                if !std::mem::replace(&mut used[unknown as usize], true) {
                    idle |= 1 << k;
                }
            }
            if idle != 0 {
                let (q, barycentric) = (self.points.len(), [1.0, 0.0, 0.0, 0.0]);
                self.points.push(At { cell: c, q, barycentric, x: corner, weight: 1.0 });
                self.forms.push(Form::Idle(idle));
            }
        }
    }

    /// Positions of some of the cells in the list, and the cells.
    fn of_cells<'a>(&'a self, cells: &'a [u32]) -> impl Iterator<Item = (usize, u32)> + 'a {
        cells.iter().filter_map(|&c| Some((self.cells.binary_search(&c).ok()?, c)))
    }

    /// Numbers the unknowns of these cells.
    fn number(&mut self, space: &Space<D>, identified: &[u32], cells: Vec<u32>) {
        self.cells = cells;
        let mut count = 0;
        let mut numbers = [vec![NONE; identified.len()], vec![NONE; identified.len()]];
        let mut number = |list: usize, node: u32| {
            let number = &mut numbers[list][identified[node as usize] as usize];
            if *number == NONE {
                *number = count;
                count += 1;
            }
            *number
        };
        self.unknowns = Vec::with_capacity(self.cells.len());
        for &c in &self.cells {
            let nodes = space.cell_nodes(c as usize);
            let tensions: Vec<u32> = nodes[..=D].iter().map(|&n| number(0, n)).collect();
            let moments = nodes.iter().map(|&n| number(1, n));
            self.unknowns.push(tensions.into_iter().chain(moments).collect());
        }
        self.unknowns.iter_mut().for_each(|list| list.push(count));
        self.len = count as usize + 1;
    }
}

/// The cells that an interface cuts, ascending.
fn cut_cells<const D: usize>(points: &[SurfacePoint<D>]) -> Vec<u32> {
    points.chunk_by(|a, b| a.at.cell == b.at.cell).map(|g| g[0].at.cell as u32).collect()
}

/// True if the ascending list `all` has each of `some`.
fn holds(all: &[u32], some: &[u32]) -> bool {
    some.iter().all(|c| all.binary_search(c).is_ok())
}

/// Cut cells with some layers of cells about them, ascending.
fn about<const D: usize>(space: &Space<D>, identified: &[u32], cut: &[u32]) -> Vec<u32> {
    let mesh = space.mesh();
    let corners = |c: usize| mesh.cell(c).iter().map(|&v| identified[v as usize] as usize);
    let mut chosen = vec![false; mesh.cell_count()];
    cut.iter().for_each(|&c| chosen[c as usize] = true);
    for _ in 0..LAYERS {
        let mut near = vec![false; identified.len()];
        let inside = (0..chosen.len()).filter(|&c| chosen[c]);
        inside.flat_map(corners).for_each(|n| near[n] = true);
        for c in 0..chosen.len() {
            chosen[c] = chosen[c] || corners(c).any(|n| near[n]);
        }
    }
    (0..chosen.len()).filter(|&c| chosen[c]).map(|c| c as u32).collect()
}

impl<const D: usize> Block<D> for System<D> {
    fn len(&self) -> usize {
        self.len
    }
    fn points(&self) -> &[At<D>] {
        &self.points
    }
    fn cells(&self) -> Option<&[u32]> {
        Some(&self.cells)
    }
    fn unknowns(&self, cell: usize, out: &mut Vec<u32>) {
        if let Ok(i) = self.cells.binary_search(&(cell as u32)) {
            out.extend_from_slice(&self.unknowns[i]);
        }
    }
    fn coupling(&self, at: &At<D>, k: usize) -> VectorForm<D> {
        let zero = (SVector::zeros(), SMatrix::zeros());
        let Form::Surface(f) = &self.forms[at.q] else { return zero };
        match Self::local(k) {
            Unknown::Tension(k) => {
                let tangential = SMatrix::identity() - f.normal * f.normal.transpose();
                (SVector::zeros(), tangential * f.barycentric[k])
            }
            Unknown::Moment(k) => {
                let along = f.normal * f.gradients[k].transpose();
                (SVector::zeros(), along - f.form * f.values[k])
            }
            Unknown::Jump => (f.normal, SMatrix::zeros()),
        }
    }
    fn own(&self, at: &At<D>, j: usize, k: usize) -> f64 {
        let softness = self.rates.softness;
        match (&self.forms[at.q], Self::local(j), Self::local(k)) {
            (Form::Surface(f), Unknown::Moment(j), Unknown::Moment(k)) => {
                -softness * f.values[j] * f.values[k]
            }
            (Form::Across { tension, .. }, Unknown::Tension(j), Unknown::Tension(k)) => {
                -tension[j] * tension[k]
            }
            (Form::Across { moment, .. }, Unknown::Moment(j), Unknown::Moment(k)) => {
                -softness * moment[j] * moment[k]
            }
            (Form::Idle(bits), ..) if j == k && bits >> k & 1 == 1 => -1.0,
            _ => 0.0,
        }
    }
    fn source(&self, at: &At<D>, k: usize) -> f64 {
        let Form::Surface(f) = &self.forms[at.q] else { return 0.0 };
        match Self::local(k) {
            Unknown::Tension(k) => self.rates.stretching * f.barycentric[k],
            Unknown::Moment(k) => -self.rates.rate * f.curvature * f.values[k],
            Unknown::Jump => self.rates.swelling,
        }
    }
}
