# %% Solve the generic knee and open the result: the passive motion, flexion 0 to 90 degrees.
import sys

import matplotlib.pyplot as plt
import numpy as np

import vrda

job = vrda.Job(sys.argv[1], set={"grid.flexion": {"from": 0, "to": 90, "step": 5}, "grid.varus": "free"})
knee = vrda.open(job.run("knee.h5", progress=lambda done, total: print(f"{done} of {total} attitudes")))

# %% Screw-home, and anterior laxity at 30 degrees: the tibia pulled forwards and backwards by 100 N.
joint, force_n = job.joint(), np.linspace(-100, 100, 21)
passive = joint.solve(flexion=np.arange(0, 31, 5))
drawer = joint.solve(flexion=30, loads={"lateral_force_n": np.stack([force_n, 0 * force_n], axis=1)}, seed=passive)
print(vrda.__version__, *np.unique(drawer.status), f"{np.ptp(drawer.anterior):.1f} mm from -100 to 100 N")
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
left.plot(knee.flexion, knee.internal_rotation[:, 0])
left.set(title="Screw-home", xlabel="flexion, degrees", ylabel="internal rotation, degrees")
right.plot(force_n, drawer.anterior)
right.set(title="Laxity at 30 degrees", xlabel="anterior force, N", ylabel="anterior translation, mm")
figure.savefig("knee.png")
