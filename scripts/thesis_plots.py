"""Plots of scripts/thesis: the motion of the knee (figures 3, 4, 5, 16) and the geometry of the bench (20, 25). Each returns its numbers."""
import h5py
import matplotlib
import numpy as np
from thesis_diagrams import BLUE, DELTA_UP, GREEN, GREY, INK, KINDS, ORANGE, RED, arrow, hull, mesh, pyplot, save, section

CONDYLE_Z_MM = {"medial": -24.0, "lateral": 24.0}  # sections through the condyles of the generic right knee
COARSE = 10  # degrees of flexion between the poses of the smoother curve of centres


def motion(model):
    """Flexion, poses, instant centres and helical axes of the zero-varus motion."""
    with h5py.File(model) as file:
        group = file["zero_varus"]
        found = {key: group[key][:] for key in ("X_reference_moving", "instant_centre", "helical_point", "helical_direction", "internal_rotation",
                                                "varus", "source")}
        found["flexion"] = file["flexion"][:]
        found["set"] = group.attrs["set"]
    return found


def instant_centre(X0, X1):
    """Centre in the sagittal plane between two poses, rotation centre at the origin (schemas/clinical.md)."""
    D = X1 @ np.linalg.inv(X0)
    half_cot = 1.0 / np.tan(np.arctan2(D[1, 0] - D[0, 1], D[0, 0] + D[1, 1]) / 2.0)
    x, y = D[0, 3], D[1, 3]
    return np.array([x - half_cot * y, y + half_cot * x]) / 2.0


def centres_figure(path, model):
    """Figure 3: the curve of the instant centre on the femur, sagittal plane."""
    knee = motion(model)
    vertices, triangles = mesh(model, "reference")
    fine = knee["instant_centre"]
    coarse = np.array([instant_centre(knee["X_reference_moving"][k], knee["X_reference_moving"][k + COARSE]) for k in range(0,
        len(fine) - COARSE + 1, COARSE // 2)])
    angles = knee["flexion"][:len(fine) - COARSE + 1:COARSE // 2] + COARSE / 2
    figure, axes = pyplot.subplots(1, 2, figsize=(10.6, 4.9), layout="constrained", width_ratios=(1.25, 1))
    for axis in axes:
        for name, z in CONDYLE_Z_MM.items():
            cut = section(vertices, triangles, np.array([0.0, 0.0, z]), np.array([0.0, 0.0, 1.0]))
            axis.add_collection(matplotlib.collections.LineCollection(cut[:, :, :2], colors=INK if name == "medial" else GREY, lw=1.3,
                label=f"femur, {name} condyle"))
        axis.scatter(*fine.T, s=7, color=GREY, alpha=0.55, label="between successive degrees", zorder=3)
        axis.plot(*coarse.T, color=RED, lw=1.2, zorder=4)
        dots = axis.scatter(*coarse.T, c=angles, cmap="viridis", s=34, zorder=5, label=f"over {COARSE} degrees")
        axis.set(aspect="equal", xlabel="anterior, mm")
    figure.colorbar(dots, ax=axes, shrink=0.75, label="flexion, degrees")
    axes[0].set(xlim=(-32, 36), ylim=(-32, 30), ylabel="proximal, mm")
    axes[0].legend(loc="upper center", ncol=2, fontsize=8.5, frameon=False)
    middle, half = (coarse.min(axis=0) + coarse.max(axis=0)) / 2, np.ptp(coarse, axis=0).max() / 2 + 1.5
    axes[1].set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half), title="enlarged")
    save(figure, path)
    inside = (np.abs(fine[:, 0]) < 40) & (np.abs(fine[:, 1]) < 40)
    return {"first": coarse[0].tolist(), "middle": coarse[len(coarse) // 2].tolist(), "last": coarse[-1].tolist(),
            "extent_mm": np.ptp(coarse, axis=0).tolist(), "outside": int((~inside).sum()), "set": knee["set"],
            "length_mm": float(np.linalg.norm(np.diff(coarse, axis=0), axis=1).sum())}


def helical_axis(X0, X1):
    """Point nearest to the origin and direction of the finite helical axis between two poses."""
    D = X1 @ np.linalg.inv(X0)
    R, d = D[:3, :3], D[:3, 3]
    s = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2.0
    angle = np.arctan2(np.linalg.norm(s), (np.trace(R) - 1.0) / 2.0)
    n = s / np.linalg.norm(s)
    u = d - (d @ n) * n
    return (u + np.cross(n, u) / np.tan(angle / 2.0)) / 2.0, n


def axes_figure(path, model):
    """Figure 4: helical axes over ten degrees each, with the condyles."""
    knee = motion(model)
    vertices, triangles = mesh(model, "reference")
    colours = matplotlib.colormaps["viridis"]
    figure = pyplot.figure(figsize=(10.6, 4.8), layout="constrained")
    figure.get_layout_engine().set(wspace=0.12)
    space, above = figure.add_subplot(1, 2, 1, projection="3d", computed_zorder=False), figure.add_subplot(1, 2, 2)
    steps = range(0, len(knee["flexion"]) - COARSE, COARSE)
    found = [helical_axis(knee["X_reference_moving"][k], knee["X_reference_moving"][k + COARSE]) for k in steps]
    space.plot_trisurf(vertices[:, 2], vertices[:, 0], vertices[:, 1], triangles=triangles, color="#e9e1d3", alpha=0.3, lw=0, zorder=1)
    outline = hull(vertices[:, [2, 0]])
    above.fill(*outline.T, color="#f1ece2", zorder=0)
    for k, (point, n) in zip(steps, found):
        reach = 58.0 / abs(n[2])
        ends = np.array([point - reach * n, point + reach * n])
        colour = colours((knee["flexion"][k] + COARSE / 2) / 90.0)
        space.plot(ends[:, 2], ends[:, 0], ends[:, 1], color=colour, lw=2, zorder=3)
        above.plot(ends[:, 2], ends[:, 0], color=colour, lw=2)
    space.set(xlim=(-58, 58), ylim=(-58, 58), zlim=(-45, 45), xlabel="right, mm", ylabel="anterior, mm", title="from behind and the right")
    space.set_zlabel("proximal, mm")
    space.set_box_aspect((116, 116, 90), zoom=0.8)
    space.tick_params(labelsize=7)
    space.view_init(18, -62)
    above.set(aspect="equal", xlim=(-60, 60), ylim=(-45, 45), xlabel="right, mm", ylabel="anterior, mm", title="from above")
    above.grid(alpha=0.25)
    shades = pyplot.cm.ScalarMappable(cmap=colours, norm=pyplot.Normalize(0, 90))
    figure.colorbar(shades, ax=above, shrink=0.7, label="flexion, degrees")
    save(figure, path)
    from_z = [float(np.degrees(np.arccos(min(1.0, abs(n[2]))))) for _, n in found]
    return {"axes": len(found), "tilt_deg": [min(from_z), max(from_z)],
            "points_mm": float(np.linalg.norm(np.diff([p for p, _ in found], axis=0), axis=1).sum())}


def flow_figure(path, trace):
    """Figure 5: the flow chart, with the counts of all searches of the knee's grid."""
    count = {name: int((trace.moves["kind"] == k).sum()) for k, name in enumerate(KINDS)}
    held = trace.moves["in_contact"] == 1
    contacts, cycles = int(np.diff(trace.moves["contact_start"])[held].sum()), int((trace.moves["is_cycle"][held] == 1).sum())
    n, stable = len(trace.searches["status"]), int((trace.searches["status"] == 0).sum())
    width, height, left, right = 3.9, 0.95, 2.2, 7.4
    boxes = {
        "start": (left, 9.3, f"start from a neighbour's pose\n{n:,} searches, {count['retreat']:,} retreats"),
        "approach": (left, 7.7, f"move along Delta until contact\n{count['approach']:,} moves"),
        "points": (left, 6.1, f"contact points and normals\n{contacts:,} contacts in {int(held.sum()):,} poses"),
        "cycle": (left, 4.5, f"pose visited before? halve the step\n{cycles:,} times"),
        "torque": (left, 2.9, "do all moments about a centre\nhave one sign?"),
        "small": (left, 1.3, "average of the motion vectors\nbelow the resolution?"),
        "stable": (left, -0.3, f"stable\n{stable:,} of {n:,} searches"),
        "rotate": (right, 2.9, f"rotate about Delta\n{count['rotate']:,} moves"),
        "translate": (right, 1.3, f"translate across Delta\n{count['translate']:,} moves"),
        "bisect": (right, 6.1, f"collision? bisect the motion\n{count['bisect']:,} trials"),
    }
    figure, axis = pyplot.subplots(figsize=(8.4, 6.8), layout="constrained")
    for name, (x, y, words) in boxes.items():
        is_end = name in ("start", "stable")
        axis.add_patch(pyplot.Rectangle((x - width / 2, y - height / 2), width, height, fc="#e6f4ea" if is_end else "#f2f5f8",
            ec=GREEN if is_end else BLUE))
        axis.text(x, y, words, ha="center", va="center", fontsize=9.5)
    for upper, lower, word in (("start", "approach", ""), ("approach", "points", ""), ("points", "cycle", ""), ("cycle", "torque", ""),
                               ("torque", "small", "no"), ("small", "stable", "yes")):
        y = boxes[upper][1] - height / 2
        arrow(axis, (left, y), (0.0, boxes[lower][1] + height / 2 - y), INK, 1.3)
        axis.text(left + 0.15, y - 0.33, word, color=ORANGE, va="center")
    for one, other, word in (("torque", "rotate", "yes"), ("small", "translate", "no")):
        arrow(axis, (left + width / 2, boxes[one][1]), (right - left - width, 0.0), INK, 1.3)
        axis.text((left + right) / 2, boxes[one][1] + 0.15, word, color=ORANGE, ha="center")
    edge = right + width / 2
    for name in ("rotate", "translate"):
        axis.plot([edge, edge + 0.5], [boxes[name][1]] * 2, color=INK, lw=1.3)
    axis.plot([edge + 0.5] * 2, [boxes["translate"][1], boxes["bisect"][1]], color=INK, lw=1.3)
    arrow(axis, (edge + 0.5, boxes["bisect"][1]), (-0.5, 0.0), INK, 1.3)
    axis.plot([right] * 2, [boxes["bisect"][1] + height / 2, boxes["approach"][1]], color=INK, lw=1.3)
    arrow(axis, (right, boxes["approach"][1]), (left + width / 2 - right, 0.0), INK, 1.3)
    axis.set(xlim=(0.1, edge + 0.7), ylim=(-0.95, 9.95))
    axis.axis("off")
    save(figure, path)
    return {"searches": n, "stable": stable, "moves": len(trace.moves["kind"]), "in_contact": int(held.sum()), "contacts": contacts,
        "cycles": cycles, **count}


def second_differences(values):
    """Root mean square of the second differences along flexion."""
    return float(np.sqrt(np.nanmean(np.diff(values, n=2, axis=0) ** 2)))


def smoothing_figure(path, model):
    """Figure 16: the thesis's Z is posterior, ours X is anterior; raw surface left, degree 6 in the middle, both at zero varus right."""
    with h5py.File(model) as file:
        flexion, varus = file["flexion"][:], file["varus"][:]
        raw, smooth = {}, {}
        for key in ("tx", "tz", "theta"):
            raw[key], smooth[key] = file[key][:], file[f"smoothed/degree_6/{key}"][:]
        rms = {key: float(file[f"smoothed/degree_6/{key}"].attrs["rms"][0]) for key in ("tx", "ty", "tz", "theta")}
    figure = pyplot.figure(figsize=(11.4, 4.1), layout="constrained")
    F, V = np.meshgrid(flexion, varus, indexing="ij")
    low, high = -np.nanmax(raw["tx"]), -np.nanmin(raw["tx"])
    for column, (values, title) in enumerate(((raw, "as solved"), (smooth, "smoothed by degree 6"))):
        axis = figure.add_subplot(1, 3, column + 1, projection="3d")
        axis.plot_surface(F, V, -values["tx"], cmap="viridis", rcount=91, ccount=21, lw=0.1, edgecolor="#00000030", vmin=low, vmax=high)
        axis.set(xlabel="flexion, °", ylabel="varus, °", title=f"posterior translation, mm, {title}", zlim=(low, high), yticks=(-10, 0, 10))
        axis.tick_params(labelsize=7)
        axis.set_box_aspect((1.2, 1, 0.85), zoom=0.88)
        axis.view_init(24, -58)
    axis = figure.add_subplot(1, 3, 3)
    middle = int(np.argmin(np.abs(varus)))
    axis.plot(flexion, -raw["tx"][:, middle], color=GREY, lw=1.2, label="as solved")
    axis.plot(flexion, -smooth["tx"][:, middle], color=RED, lw=1.8, label="degree 6")
    axis.set(xlabel="flexion, °", ylabel="posterior, mm", title="at varus 0")
    axis.grid(alpha=0.3)
    axis.legend(frameon=False)
    save(figure, path, colours=256)
    return {"rms": rms, "second_differences": {key: [second_differences(raw[key]), second_differences(smooth[key])] for key in raw},
            "largest_step_mm": float(np.nanmax(np.abs(np.diff(raw["tx"], axis=0)))),
            "largest_step_smooth_mm": float(np.nanmax(np.abs(np.diff(smooth["tx"], axis=0))))}


def turned(degrees):
    """Rotation about the fixed axes x, then y, then z."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return (np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]]) @ np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]]) @ np.array([[1, 0, 0], [0, cx,
        -sx], [0, sx, cx]]))


def pose_of(table):
    """4 x 4 matrix of a pose of a calibration file."""
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = turned(table["turn_deg"]), table["shift_mm"]
    return X


def eye_position(calibration, eye):
    """Position of an eye relative to the midpoint of both."""
    return np.array(calibration[eye]["eyepoint_mm"])


def eyes_figure(path, calibration):
    """Figure 20: both eyes, the virtual images of the screens and what each eye sees of them, from above."""
    figure, axis = pyplot.subplots(figsize=(6.0, 5.6), layout="constrained")
    depth = calibration["image_distance_mm"]
    result = {}
    for eye, colour in (("left", BLUE), ("right", RED)):
        one, at = calibration[eye], eye_position(calibration, eye)
        left, _, width, _ = one["visible"]
        ends = [at + np.array([(x - one["sight_px"][0]) / one["distance_px"] * depth, 0.0, -depth]) for x in (left, left + width)]
        for end in ends:
            axis.plot([at[0], end[0]], [-at[2], -end[2]], color=colour, lw=1)
        axis.fill([at[0], ends[0][0], ends[1][0]], [-at[2], -ends[0][2], -ends[1][2]], color=colour, alpha=0.08)
        axis.plot([ends[0][0], ends[1][0]], [-ends[0][2], -ends[1][2]], color=colour, lw=3, label=f"virtual image of the {eye} screen")
        axis.plot(at[0], -at[2], "o", color=colour, ms=8)
        axis.annotate("$E_L$" if eye == "left" else "$E_R$", (at[0], -at[2]), textcoords="offset points", xytext=(-18 if eye == "left" else 8,
            -14), fontsize=12)
        result[eye] = {"half_field_deg": [float(np.degrees(np.arctan((one["sight_px"][0] - left) / one["distance_px"]))),
                                          float(np.degrees(np.arctan((left + width - one["sight_px"][0]) / one["distance_px"])))]}
    axis.set(aspect="equal", xlabel="right, mm", ylabel="depth, mm", ylim=(-60, depth + 160), xlim=(-420, 420))
    axis.legend(loc="upper center", frameon=False, fontsize=9)
    axis.grid(alpha=0.25)
    save(figure, path)
    result["ipd_mm"] = float(np.linalg.norm(eye_position(calibration, "right") - eye_position(calibration, "left")))
    result["depth_mm"] = depth
    return result


def frames_figure(path, calibration, X_tracker_leg, rectangles):
    """Figure 25: the frames of the calibration, from above and from the side, in axes of the table W."""
    X_tracker_table = pose_of(calibration["table"])
    to_table = np.linalg.inv(X_tracker_table)
    X_table_eyes = pose_of(calibration["eyes"])
    X_table_leg = to_table @ X_tracker_leg
    frames = {"O": to_table, "W": np.eye(4), "E": X_table_eyes, "F": X_table_leg, "K": X_table_leg @ pose_of(calibration["leg"])}
    figure, axes = pyplot.subplots(2, 1, figsize=(11.4, 6.6), layout="constrained", sharex=True, height_ratios=(0.72, 1.08))
    names = {"O": "O: tracker", "W": "W: table", "E": "E: middle of the eyes", "F": "F: body on the leg", "K": "K: knee model"}
    offsets = {0: {"O": (-66, -4), "W": (-62, -16), "E": (8, 10), "F": (48, -14), "K": (-88, 6)},
               1: {"O": (-66, -12), "W": (-62, -4), "E": (8, -16), "F": (30, 18), "K": (-88, 2)}}
    limits = {0: (260, -460), 1: (-640, 440)}
    for axis, up, title in ((axes[0], 0, "from above"), (axes[1], 1, "from the side")):
        for name, X in frames.items():
            for k, colour in enumerate((RED, GREEN, BLUE)):
                arrow(axis, (X[2, 3], X[up, 3]), 150 * np.array([X[2, k], X[up, k]]), colour, 1.8)
            axis.annotate(names[name], (X[2, 3], X[up, 3]), textcoords="offset points", xytext=offsets[up][name], fontsize=9.5, weight="bold",
                zorder=8)
        for first, second, words, part in (("O", "W", "$M_{OW}$", 0.45), ("W", "E", "$M_{WE}$", 0.55), ("O", "F", "$M_{OF}$", 0.6), ("E", "K",
        "$M_{EK}$", 0.3)):
            a, b = frames[first][[2, up], 3], frames[second][[2, up], 3]
            axis.plot(*np.array([a, b]).T, "--", color=GREY, lw=1, zorder=0)
            axis.text(*(a + part * (b - a)), words, color=INK, fontsize=10.5, ha="center", va="center", bbox={"fc": "white", "ec": "none", "pad": 1})
        origin = X_table_eyes[:3, 3]
        for k, (width, behind) in enumerate(rectangles):
            z = origin[2] - calibration["nearest_rectangle_mm"] - behind
            half = width / 2 if up == 0 else 40  # their height is not part of the step
            axis.plot([z, z], [origin[up] - half, origin[up] + half], ":", color=ORANGE, lw=2,
                label="rectangles of the field of view" if k == 0 else None)
        axis.set(aspect="equal", title=title, ylabel=("X" if up == 0 else "Y") + " of W, mm", xlim=(-480, 2850), ylim=limits[up])
        axis.grid(alpha=0.25)
    for colour, name in ((RED, "X"), (GREEN, "Y"), (BLUE, "Z")):
        axes[0].plot([], [], color=colour, label=name)
    axes[0].legend(loc="upper right", frameon=False, fontsize=9, ncol=4)
    axes[1].set_xlabel("Z of W (towards the viewer), mm")
    save(figure, path)
    return {name: {"position_mm": X[:3, 3].round(1).tolist()} for name, X in frames.items()} | {
        "M_EK": (np.linalg.inv(X_table_eyes) @ frames["K"]).round(4).tolist()}
