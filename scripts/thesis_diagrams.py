"""Diagrams of scripts/thesis: chapters 2, 3 and 5, drawn from motion models and traces. Each returns the numbers that the page states."""
import h5py
import matplotlib
import numpy as np
from PIL import Image

matplotlib.use("agg")
from matplotlib import pyplot  # noqa: E402

DPI = 100
INK, GREY, BLUE, RED, GREEN, ORANGE = "#202830", "#9aa4ad", "#2b6cb0", "#c53030", "#2f855a", "#c05621"
KINDS = ("retreat", "approach", "bisect", "rotate", "translate")
DELTA_UP = np.array([0.0, 1.0, 0.0])  # every job of the page pushes along +Y
pyplot.rcParams.update({"font.size": 10, "axes.titlesize": 10.5, "axes.edgecolor": GREY, "axes.grid": False})


def save(figure, path, colours=None):
    """Writes a PNG without the time and the version of the program; with a number of colours as a palette, which is smaller."""
    figure.savefig(path, dpi=DPI, metadata={"Software": None})
    pyplot.close(figure)
    if colours:
        Image.open(path).convert("RGB").quantize(colours, dither=Image.Dither.NONE).save(path, optimize=True)


def rotation_y(degrees):
    """Rotation about Delta."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def attitude(flexion, varus):
    """Rotation of the reference in the world frame, right joint, Delta = +Y."""
    f, v = np.radians(flexion), np.radians(-varus)
    about_z = np.array([[np.cos(f), -np.sin(f), 0.0], [np.sin(f), np.cos(f), 0.0], [0.0, 0.0, 1.0]])
    return np.array([[1.0, 0.0, 0.0], [0.0, np.cos(v), -np.sin(v)], [0.0, np.sin(v), np.cos(v)]]) @ about_z


class Trace:
    """A trace in memory: moves, their contacts, searches."""

    def __init__(self, path):
        with h5py.File(path) as file:
            self.moves = {key: file[f"moves/{key}"][:] for key in file["moves"] if key not in ("move", "move_bound")}
            self.searches = {key: file[f"searches/{key}"][:] for key in file["searches"] if key not in ("search", "search_bound")}
            self.points, self.normals = (file[f"contacts/{key}"][:].astype(float) for key in ("point", "normal"))

    def moves_of(self, search):
        """First and end of the moves of a search."""
        return self.searches["move_start"][search], self.searches["move_start"][search + 1]

    def contacts(self, move):
        """Points and normals of a move in contact."""
        rows = slice(*self.moves["contact_start"][move:move + 2])
        return self.points[rows], self.normals[rows]

    def pose(self, move):
        """Rotation and translation of the moving object after a move."""
        return rotation_y(self.moves["theta"][move]), self.moves["translation"][move].astype(float)

    def kind(self, move):
        """Name of the move's kind."""
        return KINDS[self.moves["kind"][move]]

    def predictions(self):
        """(search, move in contact, next move, kind of the next move), for every move in contact that is followed by a motion."""
        for search in range(len(self.searches["status"])):
            first, end = self.moves_of(search)
            for move in range(first, end - 1):
                if self.moves["in_contact"][move] and self.kind(move + 1) in ("rotate", "translate"):
                    yield search, move, move + 1, self.kind(move + 1)


def moments(points, normals, centre):
    """Moment of each normal about the axis through the centre parallel to Delta, mm."""
    arms = points - centre
    return arms[:, 2] * normals[:, 0] - arms[:, 0] * normals[:, 2]


def common_sign(values):
    """+1 or -1 where all moments have one sign, else 0; moments below the precision of a trace do not count."""
    signs = set(np.sign(values[np.abs(values) > 1e-4]).astype(int))
    return signs.pop() if len(signs) == 1 else 0


def centre_of_rotation(trace, before, after):
    """Centre of the rotation between two poses, perpendicular to Delta, from the poses alone."""
    (R0, t0), (R1, t1) = trace.pose(before), trace.pose(after)
    R = R1 @ R0.T
    A = (np.eye(3) - R)[np.ix_((0, 2), (0, 2))]
    x, z = np.linalg.solve(A, (t1 - R @ t0)[[0, 2]])
    return np.array([x, 0.0, z])


def mesh(path, body):
    """Vertices and triangles of the contact mesh."""
    with h5py.File(path) as file:
        return file[f"bodies/{body}/vertices"][:], file[f"bodies/{body}/triangles"][:]


def hull(points):
    """Convex outline of points in a plane (monotone chain)."""
    points = sorted(map(tuple, np.unique(np.round(points, 9), axis=0)))

    def half(ordered):
        chain = []
        for p in ordered:
            while len(chain) > 1 and np.cross(np.subtract(chain[-1], chain[-2]), np.subtract(p, chain[-2])) <= 0:
                chain.pop()
            chain.append(p)
        return chain[:-1]
    lower, upper = half(points), half(points[::-1])
    return np.array(lower + upper + lower[:1])


def section(vertices, triangles, point, normal):
    """Segments in which a plane cuts the triangles: [n, 2, 3]."""
    height = (vertices - point) @ normal
    segments = []
    for corners in triangles:
        ends = []
        for a, b in ((0, 1), (1, 2), (2, 0)):
            i, j = corners[a], corners[b]
            if (height[i] > 0) != (height[j] > 0):
                ends.append(vertices[i] + (vertices[j] - vertices[i]) * height[i] / (height[i] - height[j]))
        if len(ends) == 2:
            segments.append(ends)
    return np.array(segments)


def arrow(axis, start, vector, colour, width=1.8, **more):
    """An arrow from start to start + vector."""
    axis.annotate("", xy=np.add(start, vector), xytext=start, zorder=5,
                  arrowprops={"arrowstyle": "-|>", "color": colour, "lw": width, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 13, **more})


def seen_along_delta(axis, title):
    """An axis of the plane perpendicular to Delta: X to the right, Z up, which looks along +Y."""
    axis.set(aspect="equal", title=title, xlabel="X, mm", ylabel="Z, mm")
    axis.tick_params(labelsize=8)


def outline(axis, trace, model, move):
    """Outline of the moving object across Delta."""
    vertices, _ = mesh(model, "moving")
    R, t = trace.pose(move)
    moving = hull((vertices @ R.T + t)[:, [0, 2]])
    axis.fill(*moving.T, color="#dbe7f3", zorder=0)
    axis.plot(*moving.T, color=BLUE, lw=1.2, label="outline of the moving object")
    return moving


def window(axis, points, margin):
    """Limits a square around the points, so that contacts a few millimetres apart can be seen."""
    middle, half = (points.min(axis=0) + points.max(axis=0)) / 2, np.ptp(points, axis=0).max() / 2 + margin
    axis.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[2] - half, middle[2] + half))
    return half


def plane_arrows(axis, points, normals, length, colour, has_names=True):
    """Normals across Delta, at their points, with names on the other side of the points."""
    for k, (p, n) in enumerate(zip(points[:, [0, 2]], normals[:, [0, 2]])):
        unit = n / np.linalg.norm(n)
        arrow(axis, p, length * unit, colour)
        axis.plot(*p, "o", color=colour, ms=4.5, zorder=6)
        if has_names:
            axis.annotate(f"F{k + 1}", p, textcoords="offset points", xytext=-17 * unit, color=colour, fontsize=10.5, weight="bold", ha="center", va="center")


def rotation_figure(path, trace, model, move, margin, about_points):
    """Figures 6 and 7: contacts, normals across Delta, and the centre about which the program then rotated."""
    points, normals = trace.contacts(move)
    middle = points.mean(axis=0)
    own = [k for k in range(len(points)) if common_sign(np.delete(moments(points, normals, points[k]), k))]
    predicted = points[own].mean(axis=0) if about_points else middle
    found = centre_of_rotation(trace, move, move + 1)
    sign = common_sign(moments(points, normals, predicted))
    figure, axis = pyplot.subplots(figsize=(7.2, 6.2), layout="constrained")
    outline(axis, trace, model, move)
    half = window(axis, points, margin)
    plane_arrows(axis, points, normals, 0.28 * half, RED)
    for p in points[:, [0, 2]]:
        axis.plot(*np.array([predicted[[0, 2]], p]).T, "--", color=GREY, lw=0.9)
    for k in own if about_points else []:
        axis.plot(*points[k, [0, 2]], "o", ms=13, mfc="none", mec=ORANGE, mew=2, label="application point that can be a centre" if k == own[0] else None)
    axis.plot(*middle[[0, 2]], "x", color=GREY if about_points else GREEN, ms=10, mew=2.5,
              label="isobarycentre: moments of both signs" if about_points else "B: isobarycentre, the centre")
    if about_points:
        axis.plot(*predicted[[0, 2]], "x", color=GREEN, ms=10, mew=2.5, label="B: mean of the possible centres")
    axis.plot(*found[[0, 2]], "o", ms=16, mfc="none", mec=GREEN, mew=1.5, label="centre of the rotation in the trace")
    bend = np.linspace(np.radians(110), np.radians(110 - 80 * sign), 30)
    around = np.array([np.cos(bend), np.sin(bend)]).T * 0.17 * half + predicted[[0, 2]]
    axis.plot(*around.T, color=GREEN, lw=1.6)
    arrow(axis, around[-2], around[-1] - around[-2], GREEN)
    seen_along_delta(axis, "")
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.1), ncol=2, frameon=False, fontsize=9)
    save(figure, path)
    return {"contacts": len(points), "possible_centres": len(own), "moments_about_isobarycentre_mm": moments(points, normals, middle).round(2).tolist(),
            "moments_about_centre_mm": moments(points, normals, predicted).round(2).tolist(),
            "centre_distance_mm": float(np.linalg.norm((found - predicted)[[0, 2]])),
            "turn_deg": float(trace.moves["theta"][move + 1] - trace.moves["theta"][move])}


def rotation_about_points(trace):
    """The move with the fewest contacts whose isobarycentre is no centre but some application points are: the clearest figure 7."""
    best = None
    for _, move, _, kind in trace.predictions():
        points, normals = trace.contacts(move)
        if kind != "rotate" or len(points) < 3 or common_sign(moments(points, normals, points.mean(axis=0))):
            continue
        own = [k for k in range(len(points)) if common_sign(np.delete(moments(points, normals, points[k]), k))]
        if not 0 < len(own) < len(points):
            continue
        centre = points[own].mean(axis=0)
        near = np.linalg.norm(points[:, None] - points[None], axis=2)[np.triu_indices(len(points), 1)].min()
        if not common_sign(moments(points, normals, centre)) or near < 2.0:  # points closer than 2 mm look like one
            continue
        score = (len(points), -near)
        if best is None or score < best[0]:
            best = (score, move)
    return best[1]


def ball_figure(path, trace, model, radius_mm):
    """Figure 8: three poses of a ball in a conical dish, in the plane through the start and Delta, shown upside down."""
    first, end = trace.moves_of(int(np.flatnonzero(trace.searches["node"] != 0)[0]))
    held = [move for move in range(first, end) if trace.moves["in_contact"][move]]
    places = trace.moves["translation"][held].astype(float)
    far = np.linalg.norm((places - places[-1])[:, [0, 2]], axis=1)
    along = (places[0] - places[-1]) * [1, 0, 1]
    along /= np.linalg.norm(along)
    chosen = [held[0], held[int(np.argmin(np.abs(far - 0.5 * far[0])))], held[-1]]
    vertices, triangles = mesh(model, "reference")
    cut = section(vertices, triangles, places[-1], np.cross(along, DELTA_UP))
    balls, _ = mesh(model, "moving")
    middle = (balls.min(axis=0) + balls.max(axis=0)) / 2
    figure, axes = pyplot.subplots(1, 3, figsize=(11, 3.9), sharey=True, layout="constrained")
    result = {"moves_in_contact": len(held), "panels": []}
    to_plane = lambda p: np.stack([np.atleast_2d(p) @ along, np.atleast_2d(p)[:, 1]], axis=1)
    for axis, move, name in zip(axes, chosen, "abc"):
        R, t = trace.pose(move)
        centre = R @ middle + t
        axis.add_collection(matplotlib.collections.LineCollection([to_plane(s) for s in cut], colors=INK, lw=1.5))
        axis.add_patch(pyplot.Circle(to_plane(centre)[0], radius_mm, fc="#dbe7f3", ec=BLUE))
        points, normals = trace.contacts(move)
        across = normals * [1, 0, 1]
        across /= np.linalg.norm(across, axis=1)[:, None]
        in_plane = np.abs((points - centre) @ np.cross(along, DELTA_UP)) < 1.0
        for p, n, h in zip(points[in_plane], normals[in_plane], across[in_plane]):
            arrow(axis, to_plane(p)[0], 6 * to_plane(n)[0], GREY, 1.3)
            arrow(axis, to_plane(p)[0], 6 * to_plane(h)[0], RED)
        found = {"contacts": len(points), "drawn": int(in_plane.sum()), "length": float(np.linalg.norm(average_by_component(normals)))}
        result["panels"].append(found)
        axis.set(title=f"({name}) average of {found['contacts']} motion vector{'s' if found['contacts'] > 1 else ''}: {found['length']:.2f}", aspect="equal",
                 xlim=(-23, 23), xlabel="mm")
    axes[0].set_ylim(4, -24)
    save(figure, path)
    return result


def average_by_component(normals):
    """The translation of section 3.5: unit vectors across Delta, averaged along +X, -X, +Z and -Z."""
    across = normals[:, [0, 2]] / np.linalg.norm(normals[:, [0, 2]], axis=1)[:, None]
    mean = lambda values: values[values > 0].mean() if (values > 0).any() else 0.0
    return np.array([mean(across[:, k]) - mean(-across[:, k]) for k in (0, 1)])


def translation_with_duplicates(trace):
    """A move whose normals have duplicates and others, followed by a translation along the average by component."""
    best = None
    for _, move, after, kind in trace.predictions():
        points, normals = trace.contacts(move)
        if kind != "translate" or not 4 <= len(points) <= 5 or np.linalg.norm(normals[:, [0, 2]], axis=1).min() < 0.02:
            continue
        travel = (trace.moves["translation"][after] - trace.moves["translation"][move]).astype(float)[[0, 2]]
        sum_of_units = (normals[:, [0, 2]] / np.linalg.norm(normals[:, [0, 2]], axis=1)[:, None]).sum(axis=0)
        wanted = average_by_component(normals)
        if np.linalg.norm(travel) < 0.1 or np.linalg.norm(wanted) < 0.3:
            continue
        agree = travel @ wanted / np.linalg.norm(travel) / np.linalg.norm(wanted)
        near = np.linalg.norm(points[:, None] - points[None], axis=2)[np.triu_indices(len(points), 1)].min()
        if agree < 0.9999 or near < 2.0:
            continue
        turned = 1.0 - wanted @ sum_of_units / np.linalg.norm(wanted) / np.linalg.norm(sum_of_units)
        score = (np.linalg.norm(sum_of_units) > 2.0, turned)  # where the difference is plain to see
        if best is None or score > best[0]:
            best = (score, move)
    return best[1]


def translation_figure(path, trace, model, move):
    """Figure 9: normals across Delta, their sum, and their average by component, with the translation in the trace."""
    points, normals = trace.contacts(move)
    units = normals[:, [0, 2]] / np.linalg.norm(normals[:, [0, 2]], axis=1)[:, None]
    total, average = units.sum(axis=0), average_by_component(normals)
    travel = (trace.moves["translation"][move + 1] - trace.moves["translation"][move]).astype(float)[[0, 2]]
    figure, axes = pyplot.subplots(1, 3, figsize=(11.2, 4.2), layout="constrained")
    outline(axes[0], trace, model, move)
    half = window(axes[0], points, 8)
    plane_arrows(axes[0], points, normals, 0.28 * half, RED)
    seen_along_delta(axes[0], "(a) the moving object M, seen along Delta")
    reach = 1.2 * max(np.linalg.norm(total), 1.2)
    for axis, title, vector in ((axes[1], "(b) sum", total), (axes[2], "(c) average by component", average)):
        named = []
        for k, unit in enumerate(units):
            arrow(axis, (0, 0), unit, RED, 1.2)
            near = next((group for group in named if units[group[0]] @ unit > 0.95), None)
            if near:
                near.append(k)
            else:
                named.append([k])
        for group in named:
            mean = units[group].mean(axis=0)
            axis.annotate(", ".join(f"F{k + 1}" for k in group), 1.08 * mean / np.linalg.norm(mean), color=RED, fontsize=9,
                          ha="left" if mean[0] > 0 else "right", va="center")
        arrow(axis, (0, 0), vector, GREEN, 2.6)
        axis.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal", title=f"{title}: V of length {np.linalg.norm(vector):.2f}", xlabel="X", ylabel="Z")
        axis.axhline(0, color=GREY, lw=0.6, zorder=0)
        axis.axvline(0, color=GREY, lw=0.6, zorder=0)
    axes[2].plot(*np.array([[0, 0], reach * travel / np.linalg.norm(travel)]).T, ":", color=INK, lw=1.4, label="translation in the trace")
    axes[2].legend(loc="lower left", fontsize=8.5, frameon=False)
    save(figure, path)
    angle = lambda vector: float(np.degrees(np.arctan2(vector[1], vector[0])))
    return {"contacts": len(points), "sum": float(np.linalg.norm(total)), "average": float(np.linalg.norm(average)), "sum_direction_deg": angle(total),
            "average_direction_deg": angle(average), "trace_direction_deg": angle(travel), "trace_mm": float(np.linalg.norm(travel))}


def first_contact(trace):
    """The first move in contact with more than one contact."""
    return next(move for move in range(len(trace.moves["kind"])) if trace.moves["in_contact"][move] and len(trace.contacts(move)[0]) > 1)


def points_figure(path, scenes):
    """Figure 10, below: contacts at the centres of triangles (no moment) and at the exact points, both from the sink's surface."""
    figure, axes = pyplot.subplots(1, 2, figsize=(10, 5.2), layout="constrained")
    result = {}
    for axis, (name, trace, model, title) in zip(axes, scenes):
        move = first_contact(trace)
        points, normals = trace.contacts(move)
        vertices, triangles = mesh(model, "reference")
        inside = hull(vertices[:, [0, 2]])
        axis.fill(*inside.T, color="#f1ece2", zorder=-2)
        for corners in triangles:
            face = vertices[np.append(corners, corners[0])]
            normal = np.cross(face[1] - face[0], face[2] - face[0])
            if normal[1] < -1e-9:  # the slopes of the sink, which face the cap
                axis.plot(*face[:, [0, 2]].T, color=GREY, lw=0.7, zorder=-1)
        R, t = trace.pose(move)
        cap, faces = mesh(model, "moving")
        cap = cap @ R.T + t
        outline = hull(cap[:, [0, 2]])
        axis.plot(*outline.T, color=BLUE, lw=1.4)
        tip = cap[np.argmax(cap[:, 1])]
        for corner in outline[:-1]:
            axis.plot(*np.array([tip[[0, 2]], corner]).T, color=BLUE, lw=0.8)
        plane_arrows(axis, points, normals, 7, RED, False)
        found = moments(points, normals, points.mean(axis=0))
        axis.plot(*points.mean(axis=0)[[0, 2]], "x", color=GREEN, ms=9, mew=2.2)
        ended = float(trace.moves["theta"][-1])
        span = f"all {found.min():+.2f}" if np.ptp(found) < 0.005 else f"{found.min():+.2f} to {found.max():+.2f}"
        seen_along_delta(axis, f"{title}\nmoments {span} mm; the search ends at {abs(round(ended, 1)):g}°")
        result[name] = {"contacts": len(points), "moments_mm": [float(found.min()), float(found.max())], "end_deg": ended}
    save(figure, path)
    return result
