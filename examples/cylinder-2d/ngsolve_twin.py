"""Benchmark DFG 2D-2 in NGSolve (pip install ngsolve): the mesh, the elements (P2-P1, straight triangles) and grad-div of the scene of this folder.

    gmsh -0 ../../meshes/dfg.msh -save -format msh22 -o dfg22.msh
    python3 ngsolve_twin.py --mesh dfg22.msh --scheme implicit --dt 0.005 --tmax 8 --out ng.csv

Schemes:
    implicit  BDF2, rho (u* . grad) u + rho/2 (div u*) u, u* = 2 u^n - u^(n-1); matrix assembled and factored in every step
    imex      that of NGSolve's own tutorial on Navier-Stokes: Euler, convection of u^n explicit; matrix factored once
    sbdf2     BDF2, convection 2 N(u^n) - N(u^(n-1)) explicit; matrix factored once
A run may go on from what another left: --save FILE at its end, --start FILE. Times are CPU seconds of one thread, forces left aside.
"""
import argparse
import math
import os
import pickle
import time

os.environ["OPENBLAS_NUM_THREADS"] = "1"        # before NGSolve is loaded: idle threads of BLAS would be counted as CPU time
from netgen.read_gmsh import ReadGmsh
from ngsolve import BilinearForm, CF, Grad, GridFunction, H1, InnerProduct, Mesh, Parameter, SetNumThreads, VectorH1, div, dx, y

arguments = argparse.ArgumentParser()
arguments.add_argument("--mesh", default="dfg22.msh")
arguments.add_argument("--scheme", choices=["implicit", "imex", "sbdf2"], default="implicit")
arguments.add_argument("--dt", type=float, default=0.005)
arguments.add_argument("--tmax", type=float, default=8.0)
arguments.add_argument("--every", type=float)
arguments.add_argument("--inverse", help="default: umfpack where the matrix is not symmetric, else sparsecholesky")
arguments.add_argument("--out", default="ng.csv")
arguments.add_argument("--start")
arguments.add_argument("--save")
o = arguments.parse_args()
SetNumThreads(1)
solver = o.inverse or ("umfpack" if o.scheme == "implicit" else "sparsecholesky")
rho, nu, gd, dt = 1.0, 1e-3, 0.03075, o.dt

mesh = Mesh(ReadGmsh(o.mesh))
V = VectorH1(mesh, order=2, dirichlet="inlet|walls|cylinder")
Q = H1(mesh, order=1)
X = V * Q
(u, p), (v, q) = X.TnT()
gfu, old = GridFunction(X), GridFunction(X)
velocity, pressure = gfu.components
wind = GridFunction(V)
profile = CF((6 * y * (0.41 - y) / 0.41**2, 0))

stress = nu * InnerProduct(Grad(u) + Grad(u).trans, Grad(v)) + gd * div(u) * div(v) - div(v) * p - div(u) * q
stokes = BilinearForm(stress * dx).Assemble().mat
mass = BilinearForm(X)
mass += rho * InnerProduct(u, v) * dx
mass = mass.Assemble().mat
carried = rho * InnerProduct(Grad(u) * wind + 0.5 * div(wind) * u, v)
system = BilinearForm(X)                        # implicit: assembled with the wind of the step
alpha = Parameter(1.0)
system += (rho * alpha / dt * InnerProduct(u, v) + stress + carried) * dx
convection = BilinearForm(X, nonassemble=True)  # explicit: applied to the velocity
convection += rho * InnerProduct(Grad(u) * u, v) * dx
fixed = stokes.CreateMatrix()

body = [GridFunction(X), GridFunction(X)]       # 1 along x or y at the nodes of the cylinder
for k in (0, 1):
    body[k].components[0].Set(CF((1 - k, k)), definedon=mesh.Boundaries("cylinder"))
free = X.FreeDofs()
inverse, of = None, None
if o.start:
    with open(o.start, "rb") as file:
        gfu.vec.FV().NumPy()[:] = pickle.load(file)
old.vec.data = gfu.vec
inflow = GridFunction(X)
inflow.components[0].Set(profile, definedon=mesh.Boundaries("inlet"))

b, r, past, new, last = (gfu.vec.CreateVector() for _ in range(5))
out = open(o.out, "w")
out.write("time,cylinder_drag,cylinder_lift,front,back\n")
steps, every = round(o.tmax / dt), max(1, round((o.every or dt) / dt))
first = others = 0.0
for k in range(1, steps + 1):
    begin = time.process_time()
    t = k * dt
    a = 1.0 if k == 1 or o.scheme == "imex" else 1.5
    factor = 1.0 if o.start else (1 - math.cos(math.pi * min(t, 1))) / 2
    # past = -u^n or -2 u^n + u^(n-1)/2
    past.data = -gfu.vec if a == 1 else -2 * gfu.vec + 0.5 * old.vec
    b.data = -1 / dt * (mass * past)
    if o.scheme == "implicit":
        wind.vec.data = velocity.vec if k == 1 else 2 * velocity.vec - old.components[0].vec
        alpha.Set(a)
        system.Assemble()
        A = system.mat
        inverse = A.Inverse(free, inverse=solver)
    else:
        convection.Apply(gfu.vec, new)
        b.data -= new if k == 1 or o.scheme == "imex" else 2 * new - last
        last.data = new
        if of != a:
            fixed.AsVector().data = stokes.AsVector() + a / dt * mass.AsVector()
            inverse, of = fixed.Inverse(free, inverse=solver), a
        A = fixed
    old.vec.data = gfu.vec
    gfu.vec.data = factor * inflow.vec
    r.data = b - A * gfu.vec
    gfu.vec.data += inverse * r
    spent = time.process_time() - begin
    if k == 1:
        first = spent
    else:
        others += spent
    if k % every == 0:
        r.data = b - A * gfu.vec                # the force by the residual
        drag, lift = (20 * InnerProduct(r, g.vec) / rho for g in body)
        out.write(f"{t:.8g},{drag:.10g},{lift:.10g},{pressure(mesh(0.15, 0.2)):.9g},{pressure(mesh(0.25, 0.2)):.9g}\n")
        if not abs(drag) < 1e3:
            raise SystemExit(f"unstable at t = {t}")
out.close()
if o.save:
    with open(o.save, "wb") as file:
        pickle.dump(gfu.vec.FV().NumPy().copy(), file)
print(f"scheme {o.scheme}\nsteps {steps}\nunknowns {X.ndof}\nfirst_step {first}\nper_step {others / max(1, steps - 1)}")
