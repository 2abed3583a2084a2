"""results/player.md: the images and videos of scripts/pictures, with their sizes."""


def page(numbers, stamp):
    """The page: text about the images, which change with the models; their sizes are recorded."""
    sizes = numbers["kilobytes"]
    return TEXT.replace("STAMP", stamp).replace("SIZES", ", ".join(f"{name} {size} kB" for name, size in sizes.items()))


TEXT = """# Player images

Images and videos of `scripts/pictures` (OSMesa, 4 samples per pixel). Unless noted, the set is the player's default, `two_sided`: the motion over flexion in which both
compartments are in contact.

STAMP Sizes: SIZES.

## The generic knee (`jobs/knee-generic.toml`)

![The generic knee in flexion and extension, oblique and medial view](player/knee-generic.webp)

As a video: [player/knee-generic.mp4](player/knee-generic.mp4).

![0, 30, 60 and 90 degrees](player/knee-generic-motion.jpg)

0, 30, 60 and 90 degrees of flexion. Each bundle lies on the bones; it is grey and waves where slack, otherwise light orange to dark red from 0 to 8 % of strain: the lateral collateral ligament is taut in
extension and slack at 90 degrees. The lines of the quadriceps pull with a constant force and have no strain.

![Six views at 30 degrees, with names](player/knee-generic-views.jpg)

Six views at 30 degrees. Names lead to a visible part of the structure; what bone hides has no name.

![Structures and sections](player/knee-generic-structures.jpg)

- Top: the femur transparent, the kneecap hidden (`--see-through femur --hide patella`); both bones transparent; the section through the lateral compartment (`--section sagittal=20`), from its medial side.
- Bottom: sections through the middle, from the front (`coronal=0`) and through the plateau (`axial=-22`). Cuts of solids are filled.

![Every layer at once, with numbers and legends](player/knee-generic-screen.jpg)

All layers except the helical axis, with numbers and legends: the raw cell at 30 degrees, the femur transparent.

![Layers of the generic knee](player/knee-generic-layers.jpg)

- Top: contact points (red) and forces on the tibia (green, length proportional to force) at 30 degrees, through the femur. The femur's axes (red anterior, green proximal, blue right), flexion (orange) and varus axis (violet), Delta (white)
  and the helical axis (cyan), all objects transparent.
- Middle: gap along Delta from plateaus and menisci to the femur, bright yellow 0, dark violet 5 mm, above 6 mm the bone's colour. Left the raw cell, right the two-sided motion: both sides are in
  contact in each. The red points are those of the raw cell in both.
- Bottom: 90 degrees from the lateral side; hidden lines at 60 degrees.

## A real knee (`jobs/knee-jam-smith2019-ligaments.toml`)

![The real knee in flexion and extension](player/knee-jam-smith2019-ligaments.webp)

As a video: [player/knee-jam-smith2019-ligaments.mp4](player/knee-jam-smith2019-ligaments.mp4).

![0, 30, 60 and 90 degrees](player/knee-jam-smith2019-ligaments-motion.jpg)

The data have no femoral bone: the femur is its cartilage, an open sheet, and the lateral ligaments end at the position of the missing fibula. The posterior capsule is taut in extension and slack from 30 degrees on, both cruciate ligaments tighten
towards 90 degrees, and the medial collateral ligament wraps around the tibia (wrapping surfaces).

![Layers of the real knee](player/knee-jam-smith2019-ligaments-layers.jpg)

- Top: ligaments from behind at 0 degrees; from the medial side at 60 degrees, through the femur.
- Middle: gaps and contacts at 10 and 80 degrees: both condyles are in contact with their plateaus; the medial contact has moved back by 15 mm, the lateral one by 3.
- Bottom: contact forces at 30 degrees; axes at 45 degrees.

![Six views at 30 degrees, with names](player/knee-jam-smith2019-ligaments-views.jpg)

![Sections through the lateral compartment and from the front](player/knee-jam-smith2019-ligaments-sections.jpg)

Sections through the lateral compartment (`sagittal=20`) and from the front (`coronal=0`): bone and menisci are filled; the cut of an open sheet of cartilage is a dark line.

Meshes: Lenhart et al. 2015, Smith et al. 2019 (OpenSim-JAM, Apache-2.0).

## A prepared knee (`vrda prepare`, meshes of pymskt-dess)

![Six views at 30 degrees, with names](player/knee-prepared-views.jpg)

The meshes are two bones and their cartilage; ligaments and kneecap are the template's, transferred.

## The bench (`jobs/bench-desk.toml`)

![Both eyes' views, and the operator's panel](player/bench.jpg)

The simulated bench some seconds after its start, four samples per pixel: the leg flexes in front of the simulated tracker. The stage has not been zeroed, which both eyes' views report. With the panel the processor alone renders 30 to 40 frames per second here, without it (T) the required 60; `results/benchmarks.md` has
ten minutes of that.

## Before and after

![Both knees at 0, 30, 60 and 90 degrees, before (tubes, transparent menisci) and after](player/before-after.jpg)

Menisci are opaque tissue with rounded edges instead of transparent blocks; bundles are bands that follow their wrapping surfaces, instead of single tubes (the posterior capsule over the condyles, the medial collateral ligament
over the tibia); ambient occlusion darkens where surfaces are close. The upper row of each pair is of the program before these changes, the lower one of `scripts/pictures`.

The six standard views above (front, back, top; medial, lateral, oblique; 30 degrees) as commit `13102f45` drew and solved them. These three sheets were made once and are no
outputs of `scripts/pictures`; each is to be compared with the sheet of its knee.

![The generic knee before](player/knee-generic-before.webp)

![The real knee before](player/knee-jam-smith2019-ligaments-before.webp)

![The prepared knee before](player/knee-prepared-before.webp)

- The superficial medial collateral ligament ran through the tibia of the generic and the prepared knee (medial view: only its end is seen); it lies on bone now.
- Bundles were straight tubes and bars, blue where taut; now they are bands that fan into their footprints, on one scale of strain, and wave where slack.
- There were no names. Generic and prepared knee have a kneecap since then, hence a femur and cartilage that are partly behind it in front views.

## Memory over 100,000 frames

`VRDA_FRAMES=100000 VRDA_FRAMES_MODEL=knee.h5 test_player_frames`: the generic knee is animated in the window's frame loop, 320 x 240 pixels by OSMesa, with contacts, normals, axes and the
helical axis. 111,084 KB resident after the first 400 frames, 320 KB more after 100,000 (3 bytes per frame; a leak of one small allocation per frame would be 1,600 KB or more), and no allocation in the thread of the loop. 41 minutes on two
shared cores.

## Known limitations

- In the real knee rigid menisci are only drawn, and overlap the femoral cartilage: part of a meniscus is visible through the sheet at 0 degrees.
- The generic tibia and menisci are thesis-sized: outlines show their facets, and the meniscus's ends are cut off flat.
- The gap map is sampled at vertices: on the coarse plateau its outer border is irregular by the size of a facet.
- Contacts belong to the nearest raw cell and jump from cell to cell; on a smoothed motion they need not be where the gap map is 0.
- Fibres are drawn over the bones; the solver's own are straight where their job has no wrap.
- A section cannot fill open sheets of cartilage, which have no inside: their cut is a line.
- A cut is filled for each solid alone.
- The generic tibia has no tuberosity: the kneecap's tendon ends up to 4 mm in front of it.
- The prepared knee has no fibula, and the real knee neither that nor a femoral bone: lateral ligaments and the capsule end in the air there.
- Ridges of the prepared femur are the slices of its scan.
- Names are those of bodies, so that a point of the fibula has the tibia's name; a name has at most 40 points to choose from, and its anchor may be away from the middle.
- Edges before a shaded surface are stepped in places: ambient occlusion is computed at every second pixel.
"""
