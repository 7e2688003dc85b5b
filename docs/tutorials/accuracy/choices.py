# What the study measured, and a spectrum of one of its choices.
import flexura

study = flexura.read_study("study.json")
print(f"{len(study)} choices of {study.name}, on the front: {len(study.front) > 0}")
best = min(study.values(), key=lambda choice: choice.error)
run = next(iter(best.results().values()))
print("quantities:", ", ".join(name for name in run if "." not in name))
frequency, amplitude = run.spectrum("bend")
print(f"{best.name}: strongest at {frequency[amplitude.argmax()]:.3f} {frequency.unit}")
