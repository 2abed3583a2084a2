"""results/thesis.md: the thesis reproduced, each figure and table next to VRDA's."""
from pages.tables import table

THESIS_TRIANGLES = {"tibia": ("Tibia", 1484, 1746), "patella": ("Patella", 308, 378), "femur": ("Femur", 1300, 1516),
    "meniscus_medial": ("Medmen", 570, 665),
                    "meniscus_lateral": ("Latmen", 640, 742)}
NOT_DRAWN = (
    (1, "concept: a student at the joint", "drawing of people; contains no result"),
    (17, "Open Inventor's gview", "window of another program; VRDA's is in [player.md](player.md), the input is the job file"),
    (19, "the bench", "photograph of hardware that this project does not have"),
    (21, "Optotrak 3020 and probe", "photograph of hardware; the simulated tracker has no picture"))
REPLACED = (
    (2, "the knee and its components", "anatomical drawing without a licence", "the generated knee with its ligaments"),
    (14, "Viewpoint's knee model", "licensed meshes, not published", "the generated knee of the same components"),
    (18, "frames of the simulation", "Viewpoint's meshes", "the generated knee"),
    (26, "photographs through the optics", "mannequin leg and bench", "a virtual bench; the leg is a tube about the bones"))


def number(value, digits=2):
    """Fixed decimals without a negative zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def figure(number_of, name, words, ending="png"):
    """A figure with its caption."""
    return f"**Figure {number_of}. {name}.** {words}\n\n![Figure {number_of}: {name}](thesis/figure-{number_of:02d}.{ending})\n"


def inventory():
    """What became of each figure."""
    drawn = "3 to 13, 15, 16, 20, 22 to 25"
    rows = [(k, what, f"replaced by {ours}: {why}") for k, what, why, ours in REPLACED]
    rows += [(k, what, f"not drawn: {why}") for k, what, why in NOT_DRAWN]
    return (f"Drawn from the programs' own outputs: figures {drawn}. The others:\n\n" + table(["figure", "in the thesis", "here"], sorted(rows))
            + "\nTables of the thesis: [components](#chapter-5-the-knee) (5.2) and the frames of [chapter 8](#chapter-8-calibration); the rest of its numbers is in running text.\n")


def chapter_2(n):
    centre, axes = n["3"], n["4"]
    rows = [("instant centre", "a C-shaped curve (no numbers)", f"from ({number(centre['first'][0], 1)}, {number(centre['first'][1], 1)}) over "
             f"({number(centre['middle'][0], 1)}, {number(centre['middle'][1], 1)}) to ({number(centre['last'][0], 1)}, {number(centre['last'][1], 1)}) mm, "
             f"{number(centre['length_mm'], 0)} mm long, over 10 degrees of flexion each",
             "figure 3 of the thesis is a healthy knee of the literature; the generated condyles are nearly round, so the curve is short. Between successive "
             f"degrees {centre['outside']} of 90 centres are more than 40 mm away: zero varus moves by half columns"),
            ("instant axis", "moves and tilts (no numbers)",
            f"tilted from the medial-lateral axis by {number(axes['tilt_deg'][0], 0)} to {number(axes['tilt_deg'][1], 0)} degrees",
             "screw-home tilts the axis; contact alone does not hold rotation at large flexion")]
    return ("## Chapter 2: the joint\n\n" + figure(2, "The generated knee in front view",
        "Fibres are coloured by strain: grey slack, blue to red up to 6 %.", "jpg") + "\n"
            + figure(3, "Curve of the instant centre",
                "Zero-varus motion of degree 6, on sections through the condyles; centres as in [clinical.md](../schemas/clinical.md).") + "\n"
            + figure(4, "Helical axes", "Nine axes over ten degrees each, in the femur's frame.") + "\n"
            + table(["quantity", "thesis", "VRDA", "why different"], rows))


def chapter_3(n):
    flow, six, seven, eight, nine, ten = (n[key] for key in ("5", "6", "7", "8", "9", "10"))
    signs = lambda values: ", ".join(f"{value:+.2f}" for value in values)
    rows = [("6", "all moments about the isobarycentre B have one sign: rotation about B",
        f"{six['contacts']} contacts, moments {signs(six['moments_about_isobarycentre_mm'])} mm; "
             f"the trace rotates by {number(abs(six['turn_deg']), 0)} degree about a point {number(six['centre_distance_mm'], 2)} mm from B", "same"),
            ("7", "B fails; of three application points two can be centres, their mean is one",
            f"{seven['contacts']} contacts, about B {signs(seven['moments_about_isobarycentre_mm'])} mm; "
             f"{seven['possible_centres']} can be centres, about their mean {signs(seven['moments_about_centre_mm'])} mm; the trace rotates about a point "
             f"{number(seven['centre_distance_mm'], 2)} mm from it", "same; distance: 32-bit numbers of the trace"),
            ("8", "with one side in contact a full step; in the middle the sum is null",
            ", ".join(f"({name}) {panel['contacts']} contacts: {number(panel['length'])}" for name, panel in zip("abc", eight["panels"])),
             "a ball of facets touches at many points; the rest is below the resolution after halving the step"),
            ("9", "the sum is too long because of duplicates, the average is not",
            f"{nine['contacts']} contacts: sum {number(nine['sum'])} at {number(nine['sum_direction_deg'], 0)} degrees, average "
             f"{number(nine['average'])} at {number(nine['average_direction_deg'], 0)} degrees; the trace moves at {number(nine['trace_direction_deg'], 0)} degrees", "same rule"),
            ("10", "centres of triangles: no torque; exact points: torque",
            f"centres: moments of both signs, the cap ends at {number(abs(ten['centres']['end_deg']), 0)} degrees; exact: "
             f"{ten['exact']['contacts']} contacts, all {ten['exact']['moments_mm'][0]:+.2f} mm, it ends at {number(abs(ten['exact']['end_deg']), 0)}",
             "same; on facets the normals at the centres miss the axis slightly. Exact points are the default here, `points = \"triangle-centre\"` is the thesis's approximation")]
    return ("## Chapter 3: the algorithm\n\nVectors, points and poses are those of traces (`vrda run --trace`). Views along Delta look along +Y.\n\n"
            + figure(5, "Flow chart",
                f"Counts of all {flow['searches']:,} searches of the knee's grid, probes included: {flow['moves']:,} moves.") + "\n"
            + figure(6, "Rotation about the isobarycentre", "The cap in the sink at its first contact with all four edges.") + "\n"
            + figure(7, "Rotation about the mean of the possible centres", "A pose of the generic knee.") + "\n"
            + figure(8, "A ball between two slopes",
                f"First contact, half-way and end of the search in a conical dish, {eight['moves_in_contact']} poses in contact; upside down, as in the thesis. Red: motion "
                     "vectors, grey: normals, of the contacts within 1 mm of the plane.") + "\n"
            + figure(9, "Translation: sum and average by component", "A pose of the generic knee.") + "\n"
            + figure(10, "Pyramidal cap and sink",
                "Above: at the start, oblique and from the side. Below: normals at the centres of the triangles and at the exact points.",
                "jpg") + "\n"
            + table(["figure", "thesis", "VRDA", "why different"], rows))


def chapter_4(n):
    words = {"11": ("Ball in a dish", "ends in the middle, without a torque",
        "the ball's facets make small moments; with analytic normals it does not turn ([validation.md](validation.md), seed 107)"),
             "12": ("Bar between two pyramids", "rotates and falls onto the bottom",
             "the bar is 8 mm wide, the gap 10 mm: it stops at the first angle at which it fits"),
             "13": ("Cap in a sink", "rotates and translates to the bottom", "exact points instead of divided triangles")}
    rows, figures = [], []
    for key, (name, claim, why) in words.items():
        one = n[key]
        start, end = one["start_mm"], one["end_mm"]
        rows.append((key, claim,
            f"from ({number(start[0], 0)}, {number(start[2], 0)}) mm and {number(one['start_deg'], 0)}° to ({number(end[0])}, {number(end[2])}) mm and "
                     f"{number(one['end_deg'], 1)}°: {one['iterations']} iterations, {one['rotations']} rotations, {one['translations']} translations", why))
        figures.append(figure(int(key), name,
        "Start, half-way and end; above oblique, below from the side through the reference. Upside down: Delta points down.", "jpg"))
    rows.append(("4.2", "steps ten times the resolution are safe; reference and moving object may be exchanged",
        "random cases from fixed seeds, [validation.md](validation.md)", "same"))
    return "## Chapter 4: test objects\n\n" + "\n".join(figures) + "\n" + table(["figure", "thesis", "VRDA", "why different"], rows)


def components(n):
    rows = []
    for key, (name, polygons, triangles) in THESIS_TRIANGLES.items():
        ours = n["components"].get(key)
        rows.append((name, polygons, triangles, f"{ours:,}" if ours else "none",
            "generated, all triangles" if ours else "not part of tibiofemoral contact; patella: `joint = \"other\"`"))
    return table(["component", "thesis: polygons", "thesis: triangles", "VRDA: triangles", "why different"], rows)


def chapter_5(n):
    steps, grid, zero, sixteen, status = n["steps"], n["grid"], n["zero_varus"], n["16"], n["status"]
    audits = {one["set"]: one for one in n["audit"]}
    smooth, touch = audits["degree_6"], audits["zero_varus"]
    mm = lambda one, key: number(one[key]["mm"]) if one[key] else "0"
    rms = sixteen["rms"]
    internal = zero["internal_deg"]
    rows = [
        ("flexion; varus", "0 to -90°; +10 to -10°; step 1°",
        f"{number(grid['flexion']['from_deg'], 0)} to {number(grid['flexion']['to_deg'], 0)}°; {number(grid['varus']['from_deg'], 0)} to "
         f"{number(grid['varus']['to_deg'], 0)}°; step 1°: {sum(status.values()):,} attitudes", "sign: flexion positive here"),
        ("steps, resolutions", "1 mm, 0.1 mm; 1°, 0.1°",
        f"{steps['translation_mm']:g} mm, {steps['translation_resolution_mm']:g} mm; {steps['rotation_deg']:g}°, {steps['rotation_resolution_deg']:g}°", "same"),
        ("start; first approach", "2 cm below; 5 mm per step (appendix B)",
        f"20 mm below, {number(n['start_travel_mm'], 1)} mm to contact; {n['approach_mm']:g} mm", "same"),
        ("perceptible at 0.5 m", "0.145 mm, 0.27°", "the same thresholds in `vrda compare` and audits", "same"),
        ("length of the model", "about 20 cm", f"{number(n['length_mm'] / 10, 0)} cm", "includes both shafts"),
        ("attitudes solved", "not stated", f"{status.get('stable', 0):,} of {sum(status.values()):,}", ""),
        ("jitter of the raw translation (Z posterior)", "\"some jittering\", laid to the polygons",
        f"largest step between degrees {number(sixteen['largest_step_mm'], 1)} mm; rms of second differences "
         f"{number(sixteen['second_differences']['tx'][0])} mm",
         "same cause: with one condyle in contact the pose is nearly free, and edges stop it"),
        ("after degree 6", "\"a smooth motion\"",
        f"largest step {number(sixteen['largest_step_smooth_mm'])} mm, second differences {number(sixteen['second_differences']['tx'][1], 3)} mm; residual "
         f"{number(rms['tx'])}, {number(rms['ty'])}, {number(rms['tz'])} mm and {number(rms['theta'])}° (rms)", "same"),
        ("collision after smoothing", "\"without perceptible collision\"",
        f"{smooth['overlapping']:,} of {smooth['poses']:,} attitudes overlap, by at most {mm(smooth, 'largest_penetration')} mm; at zero varus "
         f"{touch['overlapping']} of {touch['poses']}, {mm(touch, 'largest_penetration')} mm; gap at most {mm(touch, 'largest_gap')} mm",
         "the thesis looked, VRDA measured: more than its own 0.145 mm. `--recontact` and the two-sided motion remove it: "
         f"{audits['two_sided']['overlapping']} of {audits['two_sided']['poses']} overlap there"),
        ("zero varus", "mean of the first and last varus with both condyles in contact",
        f"{zero['both_touch']} of {zero['flexions']} flexions so, {number(zero['varus_deg'][0], 1)} to "
         f"{number(zero['varus_deg'][1], 1)}°; the others from the difference of both gaps",
         "at some flexions no column of a 1° grid has both in contact"),
        ("screw-home", "\"appears to be created\"; 2.1 says external in flexion",
        "internal rotation " + ", ".join(f"{value:.1f}° at {angle}°" for angle, value in internal.items()),
         "internal in flexion, external in extension, as in the literature; 2.1 of the thesis has it reversed"),
    ]
    return ("## Chapter 5: the knee\n\n"
            "`jobs/knee-generic-contact.toml`: the generated knee by stability search, contact alone, then `vrda smooth --degree 6` and `vrda reduce --set degree_6`.\n\n"
            + figure(14, "The generated knee", "Front, medial and back view.", "jpg") + "\n" + components(n) + "\n"
            + figure(15, "Search of the knee",
                "Above: flexion and varus 0 from 20 mm below. Below: flexion 40 and varus -8, 0 and 8 degrees: the femur is rotated, the tibia is pushed against it.", "jpg") + "\n"
            + figure(16, "Smoothing by degree 6", "Posterior translation, the thesis's Z.") + "\n" + table(["quantity", "thesis", "VRDA",
                "why different"], rows))


def chapters_6_and_7(n):
    eyes = n["20"]
    halves = lambda side: f"{number(sum(eyes[side]['half_field_deg']), 1)}°"
    rows = [("table", "six numbers, one degree apart", "`/zero_varus`, one pose per degree; the two-sided motion every quarter of a degree",
        "interpolated, since the bench tracks flexion"),
            ("frame buffer", "1280 x 1024, eyes in its right quarters of 640 x 480",
            f"windows {', '.join(f'{w[2]:g} x {w[3]:g}' for w in n['calibration']['windows'].values())} at the same places", "same"),
            ("nominal distance", "0.8 m", f"{number(eyes['depth_mm'] / 1000, 1)} m", "same"),
            ("horizontal field of view", "not stated", f"left {halves('left')}, right {halves('right')}", "virtual bench, seed 1"),
            ("stage encoder; potentiometer", "5 micrometres; 10 bits", "the same, simulated", "no hardware"),
            ("tracker", "0.1 mm, about 100 Hz", "simulated: 0.1 mm and 0.03° of noise", "no hardware")]
    return ("## Chapters 6 and 7: simulation and bench\n\n" + figure(18, "Frames of the motion",
        "Zero-varus motion of degree 6; oblique, medial and back view.", "jpg") + "\n"
            + figure(20, "Both eyes and the virtual images",
                "Found by the calibration of the virtual bench; the drawn width is the visible part.") + "\n" + table(["quantity", "thesis",
                "VRDA", "why different"], rows))


def chapter_8(n):
    cal, rectangles, frames = n["calibration"], n["24"], n["25"]
    rows = []
    for side in ("left", "right"):
        one = rectangles[side]
        rows += [(f"{side}: X1, X2", "", f"{number(one['X_px'][0], 1)}, {number(one['X_px'][1], 1)} px",
            f"widths {one['L_mm'][0]:g} and {one['L_mm'][1]:g} mm, {one['Z_mm']:g} mm apart in depth"),
                 (f"{side}: d", "X1 X2 Z / (X1 L2 - X2 L1)", f"{number(one['d_px'], 1)} px", f"{number(one['fitted_d_px'], 1)} px"),
                 (f"{side}: EZ1", "L1 d / X1", f"{number(one['EZ1_mm'], 1)} mm", f"{number(one['fitted_EZ1_mm'], 1)} mm"),
                 (f"{side}: EZ2", "L2 d / X2 (the thesis prints X1)", f"{number(one['EZ2_mm'], 1)} mm",
                 f"{number(one['fitted_EZ1_mm'] + one['Z_mm'], 1)} mm"),
                 (f"{side}: field of view", "2 atan(Xmax / d)", f"{number(one['field_deg'], 2)}°", f"{number(one['fitted_field_deg'], 2)}°")]
    frame_words = {"O": "tracker (Optotrak)", "W": "optical table, from both rails; origin where a marker meets the bull's eye",
    "E": "middle of the eyes, carried by the stage", "F": "body with markers on the leg"}
    frame_rows = [(key, frame_words[key], ", ".join(number(x, 0) for x in frames[key]["position_mm"])) for key in ("O", "W", "E", "F")]
    frame_rows.append(("K", "geometrical knee model", ", ".join(number(x, 0) for x in frames["K"]["position_mm"])))
    before, after = cal["targets"]["before"]["mm"], cal["targets"]["after"]["mm"]
    visible, windows = cal["visible"], cal["windows"]
    seen = "; ".join(f"{side}: {visible[side][2]} x {visible[side][3]} of {windows[side][2]:g} x {windows[side][3]:g} px" for side in ("left",
        "right"))
    k1 = "; ".join(f"{side} {number(cal['distortion'][f'{side}.k1'][0], 3)} ± {number(cal['distortion'][f'{side}.k1'][1], 3)}" for side in ("left", "right"))
    matrix = "\n".join("".join(f"{value:>10.3f}" for value in row) for row in frames["M_EK"])
    results = [("visible part of the windows", "smaller than the windows, off their centres (no numbers)", seen, "virtual displays, drawn at random"),
               ("distortion", "pincushion, third order (no numbers)", f"k1 {k1} (95 %)", "fifth order; fitted to nodes of a grid"),
               ("IPD", "pupillometer", f"{number(cal['ipd'][0], 1)} ± {number(cal['ipd'][1], 1)} mm", "the same, with its accuracy"),
               ("registration", "\"visually satisfying\"",
               f"40 points about the knee: median {number(before['median'], 1)} mm before, {number(after['median'], 1)} mm after; largest {number(after['largest'], 1)} mm",
                "one virtual bench; 200 are in [calibration.md](calibration.md)")]
    return ("## Chapter 8: calibration\n\n`vrda-player calibrate all --virtual --headless --seed 1`: a simulated bench, person and operator.\n\n"
            + figure(22, "Viewports", "Green: visible part of each window; amber: the scan line at an edge.") + "\n"
            + figure(23, "Pre-distortion", "As in the thesis: the optics' pincushion, the inverse drawn, and both together.") + "\n"
            + figure(24, "Eye point and field of view", "Two lines aligned with the sides of four rectangles, left eye.") + "\n"
            + "The equations of figure 24 on the nearest and the farthest rectangle, and the program's fit to all four with its own distortion:\n\n"
            + table(["eye", "equation", "two rectangles", "fit to four"], rows) + "\n"
            + figure(25, "Frames", "In axes of W, the pose of F when the first landmark was touched.") + "\n"
            + table(["frame", "attached to", "origin in W, mm"], frame_rows)
            + f"\nM_EK = inverse(M_OW M_WE) M_OF M_FK, mm:\n\n```\n{matrix}\n```\n\n"
            + figure(26, "Registration",
                "The generated knee over the surface of a leg, seen through the optics: before, with nominal eyes, and after the calibration.",
                "jpg") + "\n"
            + table(["quantity", "thesis", "VRDA", "why different"], results))


def chapter_9():
    rows = [("scaling to the subject", "planned, from external landmarks", "`[scaling]` of jobs, step *subject* of the calibration"),
        ("head tracking", "planned, on a head-mounted display", "`--head tracker`: body on the display"),
            ("tracking femur and tibia", "planned", "`leg = \"two-bodies\"`"), ("ligaments", "planned, deformable",
            "equilibrium with fibres ([living-knee.md](living-knee.md)); menisci remain rigid"),
            ("PC instead of the SGI", "planned", "any Linux PC"), ("assessment by institutions", "planned", "open: needs people and hardware")]
    return "## Chapter 9: future work\n\n" + table(["subject", "thesis", "here"], rows)


def page(numbers, stamp):
    """The whole page."""
    head = ("# Reproduction of the thesis\n\nWritten by `scripts/thesis`: the generic knee by stability search, smoothed by degree 6 and reduced to zero varus as in chapter 5 of the\n"
            "thesis (Baillot, *First Implementation of the Virtual Reality Dynamic Anatomy Tool*), its test objects and its calibration, each figure and number next to\n"
            f"that of VRDA. The motion that the programs show by default is another one: the equilibrium with ligaments, two-sided ([knee-generic](knee-generic/README.md)).\n\n{stamp}\n")
    parts = [head, "## Figures\n\n" + inventory(), chapter_2(numbers), chapter_3(numbers), chapter_4(numbers), chapter_5(numbers),
        chapters_6_and_7(numbers), chapter_8(numbers), chapter_9()]
    return "\n".join(part.rstrip("\n") + "\n" for part in parts)
