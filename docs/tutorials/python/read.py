"""Reads the results of the four-bar and the superelement of the robot's arm."""
import flexura

results = flexura.read_results("four_bar.h5")
print("runs:", list(results))
run = results["run"]
torque = run["motor.drive_force"]  # a numpy array with .unit, .name and .doc
row = abs(torque).argmax()
print(f"{torque.name} in {torque.unit}, {len(run.time)} rows, largest {abs(torque[row]):.3f} at {run.time[row]:.4f} s")

arm = flexura.read_superelement("arm.se.h5")
modes = arm.natural_modes(held=["shoulder"], count=2)  # by numpy, from the file's matrices
print(f"held at the shoulder: {modes.frequency[0]:.2f} Hz")
print(f"mass {arm.mass:.4f} kg")
