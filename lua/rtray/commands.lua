-- The commands: what help shows, what the parser accepts, what the completions offer. `module` has run(command, options, arguments).

local options = require "rtray.options"
local bench_rays = require "rtray.bench_rays"

local SCENE = { name = "SCENE", type = "scene" }

local commands = {
  {
    name = "render", summary = "render a scene to an image file", module = "rtray.render",
    arguments = { SCENE },
    options = options.take("output", "size", "samples", "workers", "define", "set", "frame", "eye", "at", "fov", "integrator", "tracer", "builder",
      "tile", "schedule", "max_depth", "shadow_samples", "opaque_shadows", "no_shadows", "filter", "crop", "seed", "memory_limit", "exposure",
      "tone", "bits", "quality", "alpha", "format", "no_metadata", "bands", "band_memory", "checkpoint", "every", "watch", "preview",
      "progress", "quiet", "json", "stats", "settings"),
    text = [[
SCENE is a Lua script, an old scene definition file (.sdf) or a mesh file (PLY, OBJ, STL). Without -o the image is NAME.png in this
folder. A setting given here wins over the chosen set, that over the script's settings, those over the built-in ones. A mesh file is
shown on a floor under a lamp, with a camera that frames it unless --eye, --at and --fov say more. Of an animation one frame is
rendered, --frame N or the first.

Ctrl-C (or SIGTERM) saves what is finished and ends; a second one ends at once. An image that does not fit the memory is rendered band
by band straight into the file; --bands asks for that.

With --checkpoint the same command goes on where an earlier one ended, in whatever way, to the same bits; a FILE of another scene, setting
or version is refused.]],
    examples = {
      "rtray render scenes/paper.lua --size 1000x700 -o paper.png",
      "rtray render scenes/paper.lua -D ior=1.3 --set draft",
      "rtray render bunny.ply --samples 64 --integrator path",
    },
  },
  {
    name = "animate", summary = "render the frames of an animation, and a film of them", module = "rtray.animate",
    arguments = { SCENE },
    options = options.take("frames", "film_output", "size", "samples", "workers", "at_once", "keep_going", "every", "define", "set", "integrator",
      "tracer", "builder", "tile", "schedule", "max_depth", "shadow_samples", "opaque_shadows", "no_shadows", "filter", "crop", "seed",
      "memory_limit", "exposure", "tone", "bits", "quality", "alpha", "format", "no_metadata", "progress", "quiet", "json", "stats"),
    text = [[
SCENE is a script that returns rt.animation. -o is a pattern with one %d or %0Nd for the frame's number, as in frame%04d.png, or a
film: .mp4, .webm, .gif, .webp, .apng, .mkv or .mov. Without -o the film is NAME.mp4 in this folder. A film's frames are kept in
OUT.frames/; ffmpeg makes the film of them.

The script runs again for every frame. A finished frame is taken over as long as what it describes, the settings, and the file's bytes
are the same; a change of the script renders the frames that it reaches. So the same command goes on after a kill, a full disk or
Ctrl-C; a frame that was begun goes on from its last checkpoint, which is written every minute, or --every SECONDS. What is known of the
frames lies beside them, in PATTERN.state/ or OUT.frames/state/.

Several processes, also on other machines, may work on one folder: start the same command twice. Frames are claimed; a claim ends with
its process, or after a minute without a sign of life.

A frame whose script fails ends the command with status 1, unless --keep-going; what is finished is kept.]],
    examples = {
      "rtray animate scenes/orbit.lua -o orbit.mp4",
      "rtray animate scenes/orbit.lua --frames 0:47:2 --size 320x180 -o small%03d.png",
    },
  },
  {
    name = "info", summary = "show what a scene holds: counts, memory, trees; without a scene: this build", module = "rtray.info",
    arguments = { { name = "SCENE", type = "scene", optional = true } },
    options = options.take("size", "samples", "workers", "define", "set", "frame", "tracers_list", "builder", "seed", "json"),
    text = [[
Prints the counts of a scene, the memory it and a render of it take, and for each tree: references, growth, build time, depth, nodes,
leaves, empty leaves with their ratio, the largest leaf, the SAH cost and bytes. --tracers picks the trees (kdtree, octree and bvh are built
unless told otherwise).]],
    examples = { "rtray info", "rtray info sponza.ply --tracers kdtree --builder binned" },
  },
  {
    name = "tree", summary = "show the trees of a scene: statistics, costs of rays, drawn cells", module = "rtray.tree",
    arguments = { SCENE },
    options = options.take("drawings", "cut", "color", "group", "shown_tracers", "builder", "size", "define", "set", "frame", "eye", "at", "fov",
      "seed", "json"),
    text = [[
Prints the statistics of every tree as info does, the leaves of one group's trees by depth and by references, what camera rays cost in
each structure (inner nodes and leaves visited, primitives tested: mean, what 95 of 100 rays stay below, max; of a kd-tree
or an octree in its cells: all that a leaf lists counts as tested, though where these are many the tracer looks at boxes among them
first), and the cost that the surface area heuristic predicts beside the one that random lines through the tree's box have: measured
without an end, as the heuristic assumes, and to the first hit.

-o DIR draws them: cells-TREE.svg, the cells where a plane meets them with the outlines of what stands in it; leaves.svg, the
histograms; cost-STRUCTURE.png and .svg, the cost of each pixel's camera ray, all on one scale. Cells too small to be seen are drawn
whole, and the picture says how many. Without --cut the plane goes through the middle, across the shortest side of the tree's box.]],
    examples = {
      "rtray tree bunny.ply", "rtray tree sponza.ply -o trees --cut y=30% --tracers kdtree,octree", "rtray tree x.lua --cut 1,0,1@0,2,0 -o trees",
    },
  },
  {
    name = "pixel", summary = "explain one pixel: its rays, what they hit and what each brought", module = "rtray.pixel",
    arguments = { SCENE, { name = "X,Y", type = "text" } },
    options = options.take("sample", "all_samples", "svg", "tracers_list", "size", "samples", "define", "set", "frame", "eye", "at", "fov",
      "integrator", "tracer", "builder", "max_depth", "shadow_samples", "opaque_shadows", "no_shadows", "filter", "seed", "json"),
    text = [[
X,Y counts from the top left, from 0. Each sample is a tree of rays: the camera ray, and from what it hits mirrored, refracted and
scattered rays and shadow rays, with hit, names, position, normal, texture coordinates and material. The lines with + are what a ray
brought; in whole film units (--json) their sum is the pixel's, and the pixel the one that render gives, to the last bit. --svg draws
the rays of one sample; --tracers tells what they cost in each structure.]],
    examples = { "rtray pixel scenes/paper.lua 500,350 --svg rays.svg", "rtray pixel scenes/paper.lua 500,350 --sample 2 --json" },
  },
  {
    name = "params", summary = "list the parameters that a script declares", module = "rtray.params",
    arguments = { SCENE },
    options = options.take("define", "set", "seed", "json"),
    text = "Prints each parameter with its value, default, limits and help, and the sets. --json gives the same for programs.",
    examples = { "rtray params scenes/paper.lua --json" },
  },
  {
    name = "convert", summary = "turn an old scene definition file into a Lua script",
    arguments = { { name = "FILE.sdf", type = "scene" } }, module = "rtray.convert",
    options = options.take("output", "force"),
    text = [[
The script renders the same bits as the file. Without -o it is written beside the file, as NAME.lua. A file that is there
already is kept, also one that -o names, unless --force.]],
    examples = { "rtray convert scenes/paper.sdf -o paper2.lua" },
  },
  {
    name = "replay", summary = "make an image again from what it says of itself; exit status 4 when it differs",
    arguments = { { name = "IMAGE", type = "file" } }, module = "rtray.replay",
    options = options.take("output", "files_folder", "print", "allow_read", "limit", "workers", "progress", "quiet", "json"),
    text = [[
An image that rtray has rendered holds its script with the modules it required, parameters, settings, the library's version and the
hashes of the files it read (in PNG and HDR files; beside the others in NAME.json). The script is run again, always in the sandbox and
without a folder to write to, the picture is rendered, and the hashes are compared: the same bits, or a line for each thing that differs
here: version, a missing or changed file, the described scene, the image. Meshes and textures are not in the image: they are looked for
below the image's folder, or --files.

--print shows the scripts and what else the image says, with control characters made visible, and runs nothing: look before you replay
a stranger's image.]],
    examples = { "rtray replay paper.png", "rtray replay paper.png --print", "rtray replay bunny.png --files ~/meshes -o again.png" },
  },
  {
    name = "compare", summary = "compare two images; exit status 4 when they differ",
    arguments = { { name = "A", type = "file" }, { name = "B", type = "file" } }, module = "rtray.compare",
    options = options.take("metric", "map", "scale", "ppd", "tolerance", "json", "quiet"),
    text = [[
Prints the number of differing pixels, the first of them, the largest difference, the mean squared error, the PSNR, the SSIM and FLIP
(Andersson and others 2020: what a person sees who flips between the two on a screen; 0 is nothing, 1 the most). --metric prints one number.

--map writes an image of where they differ: the difference of each channel, or with --metric ssim 1 - SSIM and with flip FLIP of each pixel,
as colours whose lightness rises with the value, from 0 (black, with magma) to 1.]],
    examples = { "rtray compare a.png b.png --map difference.png", "rtray compare a.png b.png --metric flip --map flip.png --tolerance 0.05" },
  },
  {
    name = "verify", summary = "check that every arrangement gives the same image; exit status 4 when not", module = "rtray.verify",
    arguments = { SCENE },
    options = options.take("size", "samples", "define", "set", "frame", "integrator", "workers_list", "tiles_list",
      "tracers_list", "seed", "json", "quiet"),
    text = [[
Renders the scene with workers 1, 2, 3, 8, tiles 8, 16, 64 and every structure, and prints the hash of each image in a table. Brute force
is left out above 10,000 primitives unless --tracers names it. The script is also run in two processes, whose descriptions must agree.]],
    examples = { "rtray verify scenes/paper.lua", "rtray verify sponza.ply --size 200x140 --samples 1" },
  },
  {
    name = "bench", summary = "measure render and build times of a scene", module = "rtray.bench",
    arguments = { SCENE },
    options = options.take("output", "size", "samples", "define", "set", "frame", "integrator", "workers_list", "tracers_list",
      "runs", "seed", "json", "quiet"),
    text = [[
Times the builders of the trees, then renders of the scene for each structure and worker count, runs interleaved, and prints medians.
-o FILE.csv writes every run in a row (RFC 4180).]],
    examples = { "rtray bench scenes/paper.lua --workers 1,2 --runs 5 -o bench.csv" },
  },
  {
    name = "bench-rays", spoken = "bench rays", summary = "measure how fast rays are answered, also by Embree; exit status 4 when hits differ",
    module = "rtray.bench_rays", arguments = { { name = "SCENE", type = "scene", optional = true, many = true } },
    options = bench_rays.options(), text = bench_rays.text,
    examples = {
      "rtray bench rays sponza.ply --tracers kdtree,octree --sets primary,diffuse",
      "rtray bench rays scenes/paper.lua --size 1920x1080 --threads 1,2 -o rays.csv",
      "rtray bench rays sponza sphere --against embree", "rtray bench rays --preset embree -o goals.csv",
    },
  },
  {
    name = "sweep", summary = "render a scene over a grid of parameters and settings; measure it", module = "rtray.sweep", arguments = { SCENE },
    options = options.take("over", "preset", "zip", "folder", "runs", "warmup", "in_process", "reference", "measure", "size", "samples", "workers",
      "define", "set", "integrator", "tracer", "builder", "tile", "schedule", "max_depth", "shadow_samples", "opaque_shadows", "no_shadows", "filter",
      "crop", "seed", "memory_limit", "no_images", "no_report", "timeout", "restart", "force_mix", "wait", "dry_run", "progress", "quiet", "json"),
    text = [[
An axis is a parameter of the script or a setting: workers, tile, schedule, size, samples, tracer, builder, integrator, accel, set and the
others that `rtray render --settings` lists. Values are lists (1,2,4), ranges with their last value (1:2.5:0.25), factors (1:16:*2), sizes
(500x500,1000x700), vectors ({1,0,0},{0,1,0}), choices, or * for all choices. The grid of all axes is rendered, with --zip their pairs.

Each run is a process of its own, one at a time, the runs of all points interleaved; medians, quartiles, speed-up, efficiency, the serial
fraction and a fit of Amdahl's law go to results.csv and results.json, an image of each point to images/. There are 3 runs of a point when an axis
leaves the picture as it is (workers, tile, tracer), else 1. After a kill or Ctrl-C the same command goes on; longer axes and more runs keep what
is there. A point that fails is noted, the others go on, and the exit status is 1; 4 says that images differ which must not.]],
    examples = {
      "rtray sweep scenes/paper.lua --over ior=1:2.5:0.25 -o glass",
      "rtray sweep scenes/paper.lua --over workers=1,2,4 --over size=500x500,1000x700 --runs 5 --warmup 1 -o report",
      "rtray sweep scenes/paper.lua --preset jpvm -o report",
      "rtray sweep scenes/cornell.lua --over samples=4:256:*4 --reference samples=256 -o noise",
    },
  },
  {
    name = "report", summary = "make the page of a sweep again, with its plots and contact sheets", module = "rtray.report_command",
    arguments = { { name = "DIR", type = "folder" } },
    options = options.take("no_plots", "json", "quiet"),
    text = [[
DIR is a folder that a sweep has written. From its results.json are made: index.html, a page that needs no network and opens from the
file, with plots, a table that can be sorted, the images side by side and what is to be known about the machine; contact.png with all
images; plots/ with each plot as SVG and PNG and the script plots.gp they come from, when gnuplot is installed. Nothing is measured
again. The page's path is printed.]],
    examples = { "rtray report report/", "rtray report report/ --no-plots" },
  },
  {
    name = "repl", summary = "read and run Lua lines, with rt loaded", module = "rtray.repl",
    arguments = { { name = "SCENE", type = "scene", optional = true } },
    options = options.take("define", "set", "seed"),
    text = [[
Each line is run; the value of an expression is printed. A SCENE stands in the variable `scene`. Works without a terminal too: lines are
then read from standard input without a prompt.]],
    examples = { "rtray repl scenes/paper.lua", "echo 'rt.version' | rtray repl" },
  },
  {
    name = "help", summary = "show help for a command", module = "rtray.help",
    arguments = { { name = "COMMAND", type = "command", optional = true } },
    options = options.take(), text = "Without a command it lists them all.", examples = { "rtray help render" },
  },
  {
    name = "completion", summary = "print the completions for a shell", hidden = true,
    arguments = { { name = "SHELL", type = "shell" } }, module = "rtray.completion", options = options.take("output"),
    text = "SHELL is bash, zsh or fish.", examples = { "rtray completion bash > /etc/bash_completion.d/rtray" },
  },
  {
    name = "manual", summary = "print a manual page", hidden = true, arguments = { { name = "COMMAND", type = "command", optional = true } },
    module = "rtray.manual", options = options.take("output"),
    text = "For man(1): the page of the program or of a command; with -o FOLDER/ all of them, as files.",
    examples = { "rtray manual sweep | man -l -" },
  },
  -- What commands run in processes of their own (child.lua).
  {
    name = "answer", summary = "answer the requests of a sweep", hidden = true, arguments = { SCENE }, module = "rtray.sweep", entry = "answer",
    options = options.take("define"), text = "Requests are JSON lines on standard input. Used by sweep.", examples = { "rtray answer x.lua" },
  },
  {
    name = "describe", summary = "print the hash of a scene's description", hidden = true, arguments = { SCENE }, module = "rtray.child",
    entry = "describe", options = options.take("define", "set", "frame", "seed"), text = "Used by verify.", examples = { "rtray describe x.lua" },
  },
  {
    name = "measure", summary = "time one render", hidden = true, arguments = { SCENE }, module = "rtray.child", entry = "measure",
    options = options.take("size", "samples", "workers", "define", "set", "frame", "integrator", "tracer", "builder", "seed"),
    text = "Prints seconds, seconds of the trees, rays, workers and the image's hash. Used by bench.", examples = { "rtray measure x.lua" },
  },
  {
    name = "build", summary = "time the builds of a scene's trees", hidden = true, arguments = { SCENE }, module = "rtray.child",
    entry = "build", options = options.take("define", "set", "frame", "tracers_list", "builder", "seed"),
    text = "Prints a line a tree: name, group, seconds, nodes, depth, SAH cost, bytes. Used by bench.", examples = { "rtray build x.lua" },
  },
}

for _, command in ipairs(commands) do
  commands[command.name] = command
end

return commands
