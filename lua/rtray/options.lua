-- Every option of the program, once. commands.lua names the ones a command takes; help, completions and the parser read the same rows.
-- type names a reader in types.lua; `setting` is the setting of a render that the option sets.

local options = { list = {} }

local function row(key, names, type, value, help, more)
  local option = { key = key, names = names, type = type, value = value, help = help }
  for k, v in pairs(more or {}) do
    option[k] = v
  end
  options[key] = option
  options.list[#options.list + 1] = option
end

row("help", { "-h", "--help" }, nil, nil, "show the command's help")
row("output", { "-o", "--output" }, "file", "FILE", "write to FILE; - is standard output")
row("film_output", { "-o", "--output" }, "file", "FILE", "write to FILE: a film, or a pattern as frame%04d.png", { key = "output" })
row("define", { "-D", "--define" }, "define", "NAME=VALUE", "set a declared parameter of the script (repeatable)", { many = true })
row("set", { "--set" }, "text", "NAME", "choose one of the script's parameter sets")

row("trust", { "--trust" }, nil, nil, "run the script with all libraries and the user's rights, outside of the sandbox")
row("allow_read", { "--allow-read" }, "folder", "FOLDER", "let a script in the sandbox read below FOLDER too (repeatable)", { many = true })
row("limit", { "--limit" }, "limits", "time=T,memory=M", "end what takes longer than T (10s, 2m) or more memory than M (512M, 2G)")

row("size", { "-s", "--size" }, "size", "WxH", "size of the image in pixels")
row("samples", { "-n", "--samples" }, "count", "N", "samples a pixel", { low = 1, high = 65536, setting = "samples" })
row("workers", { "-j", "--workers" }, "count", "N", "threads that compute; 0: all CPUs", { low = 0, high = 1024, setting = "workers" })
row("tile", { "--tile" }, "count", "N", "edge of a tile in pixels", { low = 1, high = 4096, setting = "tile" })
row("schedule", { "--schedule" }, "choice", "NAME", "how tiles are given out: dynamic or static", {
  choices = { "dynamic", "static" }, setting = "schedule",
})
row("integrator", { "--integrator" }, "choice", "NAME", "what a pixel shows: whitted, path, ao or a debug view", {
  choices = { "whitted", "path", "ao", "normal", "uv", "id", "depth", "cost", "steps" }, setting = "integrator",
})
row("tracer", { "--tracer" }, "choice", "NAME", "structure that answers rays; no effect on the picture", {
  choices = { "auto", "kdtree", "octree", "bvh", "brute" }, setting = "tracer",
})
row("builder", { "--builder" }, "choice", "NAME", "how the tree is built: kd-tree exact, binned or paper, BVH compact or spatial", {
  choices = { "auto", "exact", "binned", "paper", "compact", "spatial" }, setting = "builder",
})
row("max_depth", { "--max-depth" }, "count", "N", "bounces at most", { low = 0, high = 64, setting = "max_depth" })
row("seed", { "--seed" }, "seed", "N", "seed of the samples and of the script's math.random", { setting = "seed" })
row("shadow_samples", { "--shadow-samples" }, "count", "N", "rays to a spherical light a hit; 0: chosen", {
  low = 0, high = 65536, setting = "shadow_samples",
})
row("opaque_shadows", { "--opaque-shadows" }, nil, nil, "transparent bodies cast full shadows", { setting = "opaque_shadows" })
row("no_shadows", { "--no-shadows" }, nil, nil, "lights are never shadowed")
row("filter", { "--filter" }, "choice", "NAME", "pixel filter", { choices = { "box", "gaussian" }, setting = "filter" })
row("crop", { "--crop" }, "crop", "X,Y,W,H", "render this part of the image only", { setting = "crop" })
row("memory_limit", { "--memory-limit" }, "bytes", "BYTES", "memory the render may take, as in 512M or 2G", { setting = "memory_limit" })

row("exposure", { "--exposure" }, "number", "STOPS", "brighten by 2^STOPS when saving", { low = -32, high = 32, save = true })
row("tone", { "--tone" }, "choice", "CURVE", "tone curve when saving", { choices = { "none", "filmic" }, save = true })
row("bits", { "--bits" }, "choice", "N", "bits a channel of a PNG", { choices = { "8", "16" }, save = true })
row("quality", { "--quality" }, "count", "N", "quality of a JPEG", { low = 1, high = 100, save = true })
row("alpha", { "--alpha" }, nil, nil, "keep the coverage as alpha (PNG, TGA)", { save = true })
row("format", { "--format" }, "choice", "NAME", "image format, else by the file's ending", {
  choices = { "png", "jpg", "bmp", "tga", "hdr" }, save = true,
})
row("bands", { "--bands" }, nil, nil, "render band by band straight into the file (png, bmp, tga, hdr)")
row("band_memory", { "--band-memory" }, "bytes", "BYTES", "memory of a band, as in 256M")

row("frame", { "--frame" }, "count", "N", "the frame of an animation, counted from 0", { low = 0, high = 999999 })
row("eye", { "--eye" }, "point", "X,Y,Z", "of a mesh file: where the camera stands")
row("at", { "--at" }, "point", "X,Y,Z", "of a mesh file: what the camera looks at; else the middle")
row("fov", { "--fov" }, "number", "DEGREES", "of a mesh file: the vertical field of view", { low = 1, high = 179 })
row("frames", { "--frames" }, "frames", "RANGES", "the frames, as in 0:119 or 0:119:2 or 7,9; all unless told")
row("at_once", { "--at-once" }, "count", "N", "frames rendered at the same time; 0: chosen", { low = 0, high = 1024 })
row("keep_going", { "-k", "--keep-going" }, nil, nil, "a frame that fails does not stop the others")
row("no_metadata", { "--no-metadata" }, nil, nil, "leave script, parameters, settings and version out of the image")
row("files_folder", { "--files" }, "folder", "FOLDER", "folder that the scene's files lie in; else that of the image")
row("print", { "--print" }, nil, nil, "print what the image says and its scripts, run nothing")
row("checkpoint", { "--checkpoint" }, "file", "FILE", "keep what is done in FILE, and go on from it; removed when the image is whole")
row("every", { "--every" }, "number", "SECONDS", "time between two writings of the checkpoint, 60", { low = 0.001, high = 1e9 })
row("watch", { "--watch" }, nil, nil, "render again whenever the scene's files change")
row("preview", { "--preview" }, "file", "FILE", "while rendering, keep FILE up to date with what is done")
row("json", { "--json" }, nil, nil, "print one JSON object on standard output")
row("quiet", { "-q", "--quiet" }, nil, nil, "no progress and no closing line")
row("progress", { "--progress" }, "choice", "KIND", "auto, none, or json: one JSON object a line on standard error", {
  choices = { "auto", "none", "json" },
})
row("stats", { "--stats" }, nil, nil, "print rays, times and what each worker did")
row("settings", { "--settings" }, nil, nil, "print each setting with where its value comes from")

row("map", { "--map" }, "file", "FILE", "write the image of the differences")
row("metric", { "--metric" }, "choice", "NAME", "print and map this alone: psnr (dB), ssim (1: equal), flip (0: equal; what a person sees)", {
  choices = { "psnr", "ssim", "flip" },
})
row("scale", { "--scale" }, "choice", "NAME", "colours of --map: magma (of ssim and flip), viridis, grey, or none: the values as they are", {
  choices = { "magma", "viridis", "grey", "none" },
})
row("ppd", { "--ppd" }, "number", "N", "pixels per degree of the eye's view, for FLIP; 67", { low = 1, high = 1000 })
row("tolerance", { "--tolerance" }, "number", "E", "differences up to E of a channel's range count as equal; with --metric FLIP or 1 - SSIM", {
  low = 0, high = 1,
})

row("workers_list", { "-j", "--workers" }, "counts", "N,N,...", "worker counts", { low = 1, high = 1024 })
row("tiles_list", { "--tiles" }, "counts", "N,N,...", "tile sizes", { low = 1, high = 4096 })
row("tracers_list", { "--tracers" }, "choices", "NAME,...", "structures", { choices = { "kdtree", "octree", "bvh", "brute" } })
row("shown_tracers", { "--tracers", "--tracer" }, "choices", "NAME,...", "structures to look at",
  { choices = { "kdtree", "octree", "bvh", "brute" } })
row("runs", { "--runs" }, "count", "N", "runs of each arrangement; medians are shown", { low = 1, high = 1000 })
row("over", { "--over" }, "axis", "NAME=VALUES", "an axis: a parameter or setting and its values (repeatable), as ior=1:2.5:0.25", { many = true })
row("zip", { "--zip" }, nil, nil, "pair the axes' values instead of crossing them")
row("preset", { "--preset" }, "choice", "NAME", "axes by name: the paper's experiment, or a study of workers, structures, tiles", {
  choices = { "jpvm", "strong", "weak", "structures", "tiles" },
})
row("warmup", { "--warmup" }, "count", "N", "runs of each point before the timed ones", { low = 0, high = 1000 })
row("in_process", { "--in-process" }, nil, nil, "run in this process: trees are shared between points, times are not clean")
row("measure", { "--measure" }, "file", "FILE", "Lua file that returns function(image, stats, point) for columns of your own", {
  reads = true,
})
row("reference", { "--reference" }, "text", "AXIS=VALUE,...", "compare each image with the one of the point with these values")
row("folder", { "-o", "--output" }, "folder", "DIR", "the sweep's folder; else NAME.sweep")
row("no_images", { "--no-images" }, nil, nil, "keep no images")
row("timeout", { "--timeout" }, "number", "SECONDS", "a run that takes longer fails", { low = 0.001, high = 1e9 })
row("restart", { "--restart" }, nil, nil, "drop what the folder holds and begin again")
row("force_mix", { "--force" }, nil, nil, "keep rows of another machine or version, marked")
row("wait", { "--wait" }, nil, nil, "wait while another process works on the folder")
row("dry_run", { "--dry-run" }, nil, nil, "print the points and end")
row("no_report", { "--no-report" }, nil, nil, "make no page, contact sheets and plots; `rtray report DIR` makes them later")
row("no_plots", { "--no-plots" }, nil, nil, "do not run gnuplot; the page has its own plots all the same")
row("force", { "-f", "--force" }, nil, nil, "replace an existing file")

row("drawings", { "-o", "--output" }, "folder", "DIR", "write pictures into the folder DIR, which is made", { key = "folder" })
row("cut", { "--cut" }, "cut", "PLANE", "plane of the drawn cells: y=1.5 (coordinate), y=40% (of the tree's box) or NX,NY,NZ@PX,PY,PZ")
row("group", { "--group" }, "group", "N", "what the tree stands over, as the statistics name it: 0, 1, 0.1 (a part), top")
row("color", { "--color" }, "choice", "WHAT", "what the colour of a cell shows: depth or references", { choices = { "depth", "references" } })
row("sample", { "--sample" }, "count", "N", "tell this sample alone", { low = 0, high = 65535 })
row("svg", { "--svg" }, "file", "FILE", "draw the first told sample's rays: a slice through the scene along the camera ray")
row("all_samples", { "--all" }, nil, nil, "tell all samples")

-- The rows of some keys, in the given order, the help last. What runs a script (it takes `define`) takes what guards the machine from it.
function options.take(...)
  local list = {}
  for _, key in ipairs { ... } do
    list[#list + 1] = assert(options[key], key)
    if key == "define" then
      table.move({ options.trust, options.allow_read, options.limit }, 1, 3, #list + 1, list)
    end
  end
  list[#list + 1] = options.help
  return list
end

return options
