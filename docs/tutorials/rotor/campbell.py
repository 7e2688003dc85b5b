# Whirl speeds over the speed of the rotor, in axes that stand still, beside the speed itself.
import flexura
import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt

axes = plt.figure().gca()
for speed in range(50, 301, 50):
    modes = flexura.eigen("rotor.toml", "--fixed-axes", "--count", "5", settings={"parameters.speed": speed})["runs"][0]["modes"]
    whirls = [whirl["hz"] for mode in modes for whirl in mode["fixed_axes"] if whirl["kind"] == "circular"]
    print(f"{speed:3} rad/s:", ", ".join(f"{hz:+.2f}" for hz in sorted(whirls)), "Hz")
    axes.plot([speed] * len(whirls), [abs(hz) for hz in whirls], "k.")
axes.plot([0, 300], [0, 300 / 6.283], "--", label="speed of the rotor")
axes.set(xlabel="speed [rad/s]", ylabel="whirl [Hz]", ylim=(0, 25))
axes.figure.savefig("campbell.png")
