"""The pressure at the end, and on it the interface, coloured by its stretch."""
import pyvista as pv

fields = pv.get_reader("runs/outputs/fields.pvd")
interfaces = pv.get_reader("runs/outputs/interfaces.pvd")
for reader in (fields, interfaces):
    reader.set_active_time_value(reader.time_values[-1])
mesh = fields.read()[0]  # the only block
line = interfaces.read()[0]
print("times:", fields.time_values)
print("at the nodes:", mesh.array_names)
print("on the interface:", line.array_names)

plotter = pv.Plotter(off_screen=True, window_size=(800, 600))
bar = dict(vertical=True, height=0.6, position_y=0.2, fmt="%.3f")
right, left = bar | dict(position_x=0.86), bar | dict(position_x=0.03)
plotter.add_mesh(mesh, scalars="pressure", cmap="coolwarm", scalar_bar_args=right)
plotter.add_mesh(line, scalars="stretch", cmap="viridis", line_width=6, scalar_bar_args=left)
plotter.view_xy()
plotter.camera.zoom(1.25)
plotter.screenshot("runs/outputs/fields.png")
