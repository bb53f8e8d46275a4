"""The pressure and the interface as contours of Matplotlib: a figure with text and lines, as PDF or PNG."""
import matplotlib.pyplot as plt
import matplotlib.tri as tri
import meshio
import numpy as np

mesh = meshio.read("runs/outputs/fields/000100.vtu")  # the number is that of the step
cells = mesh.cells_dict["triangle6"]  # three corners, then the middles of the sides 01, 12, 20
parts = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]
triangles = np.vstack([cells[:, part] for part in parts])
x, y = mesh.points[:, 0], mesh.points[:, 1]
plane = tri.Triangulation(x, y, triangles)

figure, axes = plt.subplots(figsize=(4.6, 3.8), layout="constrained")
filled = axes.tricontourf(plane, mesh.point_data["pressure"].ravel(), levels=20, cmap="coolwarm")
axes.tricontour(plane, mesh.point_data["membrane.level_set"].ravel(), levels=[0], colors="black")
axes.set(xlabel="x", ylabel="y", aspect="equal")
figure.colorbar(filled, label="pressure")
figure.savefig("runs/outputs/contours.png", dpi=120)
figure.savefig("runs/outputs/contours.pdf")
