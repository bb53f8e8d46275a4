"""The half-chords over time, and the pressure along a line: two figures in one."""
import matplotlib.pyplot as plt
import pandas as pd

series = pd.read_csv("runs/outputs/series.csv", index_col="time")
profile = pd.read_csv("runs/outputs/profiles/pressure.csv", index_col="x")

figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
left.plot(series["membrane.horizontal"], label="along x")
left.plot(series["membrane.vertical"], "--", label="along y")
left.set(xlabel="time", ylabel="half-chord")
for column in profile.columns.drop(["distance", "y"]):  # a column for each time: t=0.4, t=2
    right.plot(profile[column], label=column)
right.set(xlabel="x", ylabel="pressure along y = 1")
for axes in (left, right):
    axes.legend(frameon=False)
figure.savefig("runs/outputs/series.png", dpi=120)

# Numbers for the text: the least and the largest of every column of the membrane.
print(series.filter(like="membrane.").agg(["min", "max"]).T)
