---@meta rt
-- What the module rt exports, for the Lua language server and for readers. A test compares it with the module.

---@class rt
---@field version string the library's version, as "0.1.0"
---@field build string what the library was built with
local rt = {}

---A point, direction or colour: {x, y, z}, or what rt.vec gives.
---@alias rt.vec3 number[]|rt.vec
---A file's name (relative to the script), a texture or an image.
---@alias rt.texture_like string|rt.texture|rt.image
---An object, a list of items to any depth, or false, which is skipped.
---@alias rt.item rt.shape|rt.light|rt.group|rt.instance|rt.item[]|false

-- ---- scenes ----

---@class rt.scene_desc
---@field settings? rt.settings what the command line and sets may override
---@field camera? rt.camera without one, everything finite is framed
---@field ambient? rt.vec3 light from everywhere ({0, 0, 0})
---@field background? rt.vec3|rt.texture_like a colour, or an equirectangular picture ({0, 0, 0})
---@field background_top? rt.vec3 towards +y; `background` is then towards -y
---@field name? string
---@field [integer] rt.item
local scene_desc = {}

---A scene of objects, lights and a camera.
---@param desc rt.scene_desc
---@return rt.scene
function rt.scene(desc) end

---A scene that scene:save has written. It renders and answers queries, and takes no more objects.
---@param path string
---@return rt.scene
function rt.load_snapshot(path) end

---The same as scene:render.
---@param scene rt.scene
---@param options? rt.render_options
---@return rt.image image
---@return rt.render_stats stats
function rt.render(scene, options) end

---In brackets, here and below: what holds where nothing is given.
---@class rt.settings
---@field width? integer 1 ... 1048576 (800)
---@field height? integer 1 ... 1048576 (600)
---@field size? integer[] {width, height}
---@field samples? integer a pixel (16)
---@field integrator? string "whitted", "path", "ao", "normal", "uv", "id", "depth", "cost", "steps" (whitted)
---@field max_depth? integer bounces at most, 0 ... 64 (8)
---@field seed? integer seed of the samples (0)
---@field shadows? boolean false: lights are never shadowed (true)
---@field shadow_samples? integer rays to a spherical light a hit; 0: chosen (0)
---@field opaque_shadows? boolean transparent bodies cast full shadows (false)
---@field ao_samples? integer ambient occlusion: rays a hit; 0: chosen (0)
---@field ao_distance? number ambient occlusion: reach; 0: a tenth of the scene (0)
---@field filter? "box"|"gaussian" (box)
---@field filter_width? number in pixels; 0: the filter's own (0)
---@field tracer? string "auto", "kdtree", "octree", "bvh", "brute"; no effect on the picture (auto)
---@field workers? integer threads; 0: all CPUs (0)
---@field tile? integer edge in pixels (32)
---@field schedule? "dynamic"|"static" (dynamic)
---@field memory_limit? integer bytes a render may take; 0: what is free (0)
---@field crop? { x: integer, y: integer, width: integer, height: integer } part that is rendered
---@field accel? string trees to build: "auto", "kdtree", "octree", "bvh", "brute", or several with commas (auto)
---@field builder? "auto"|"exact"|"binned"|"paper"|"compact"|"spatial" of the kd-tree: exact, binned, paper; of the BVH: compact (no copies of vertices: half the memory), spatial (splits cut triangles: slower to build, faster for rays one a call) (auto)
---@field tree_depth? integer 0: the builder's own (0)
---@field leaf_size? integer 0: the builder's own (0)
---@field cost_traverse? number 0: the builder's own (0)
---@field cost_intersect? number 0: the builder's own (0)
---@field empty_bonus? number 0: the builder's own (0)
---@field duplication? number references a primitive at most; 0: the builder's own (0)
---@field refit? number how many times more or less a BVH whose vertices have moved may cost before it is built anew, not refitted (1.25); 0: always built

---@class rt.render_options : rt.settings
---@field progress? fun(done: number, job: rt.job) called on this thread about every 50 ms; an error ends the render
---@field preview? boolean job:image() gives what is finished while the job runs
---@field checkpoint? string a file that keeps what is done; a render that finds it goes on from there, one of another scene or setting is refused
---@field checkpoint_every? number seconds between two writings, 60
---@field checkpoint_keep? boolean the file stays when the image is whole; else it is removed
---@field background? boolean a job of one worker has a thread of its own too; else it runs while it is polled and waited for

---@class rt.render_stats
---@field seconds number
---@field build_seconds number
---@field rays integer
---@field rays_camera integer
---@field rays_shadow integer
---@field rays_reflect integer
---@field rays_refract integer
---@field rays_diffuse integer
---@field rays_ao integer
---@field nodes integer visited nodes of trees; counted by the integrators "cost" and "steps" alone, else 0
---@field tests integer tested primitives; likewise
---@field clamped integer contributions that were limited
---@field dropped integer contributions that were no numbers
---@field memory integer bytes
---@field workers integer
---@field tiles integer
---@field tiles_done integer
---@field tiles_resumed integer finished tiles that came from the checkpoint
---@field tiles_begun integer tiles that came from it unfinished
---@field checkpoints integer times the checkpoint was written
---@field checkpoints_failed integer times it could not be
---@field checkpoint_seconds number spent on that by a worker
---@field touched boolean[] for each material, in the order of Scene:looks(): whether a ray looked at it
---@field per_worker { busy_seconds: number, cpu_seconds: number, rays: integer, tiles: integer }[]

---A made scene takes other `settings`; set_camera and add change the rest. Assigning to another key is an error, and so is a method that it does not
---have but that is near one.
---@class rt.scene
---@field settings rt.settings the script's own
local Scene = {}

---More items; the next render or query sees them.
---@param ... rt.item
---@return rt.scene
function Scene:add(...) end

---@param camera rt.camera
---@return rt.scene
function Scene:set_camera(camera) end

---@class rt.moved_vertices
---@field vertices rt.buffer|number[]|number[][] as many as the mesh has, in its order; of a file's, behind its transform
---@field normals? rt.buffer|number[]|number[][] else those that the mesh has stay
---@field smooth? boolean make normals of the faces; a mesh of arrays that was made so gets them again, one of a file needs to be told

---New places for the vertices of a mesh or polyhedron, wherever it stands in this scene; its faces and all else stay. The next render or query refits the
---BVH where that serves (the setting refit), which takes a tenth of a build's time. What an instance places is moved in a scene of its own:
---local part = rt.scene { mesh }, rt.instance { part }, part:set_vertices(mesh, ...).
---@param mesh rt.shape|string the object, or its name
---@param moved rt.moved_vertices
---@return rt.scene
function Scene:set_vertices(mesh, moved) end

---The camera as it stands: the description's, or framed for the last image.
---@return table
function Scene:get_camera() end

---Renders and returns the image.
---@param options? rt.render_options
---@return rt.image image
---@return rt.render_stats stats
function Scene:render(options) end

---Starts a render and returns at once.
---@param options? rt.render_options
---@return rt.job
function Scene:start(options) end

---Renders by bands straight into a PNG, BMP, TGA or HDR file, so that images larger than the memory can be made.
---@param path string
---@param options? rt.settings also: save (rt.save_options), band_memory (bytes), checkpoint, checkpoint_every, progress (a function of the part that is done, 0 to 1, called for each tile with more than before and about every 50 ms in between with the same; true ends the render)
---@return boolean done false: progress ended it, the file is as it was
function Scene:render_to_file(path, options) end

---Bytes that a render would take beside the scene.
---@param options? rt.settings
---@return integer
function Scene:memory(options) end

---The settings that hold, and where each comes from: "argument", "command line", "set NAME", "script", "built in".
---@param options? rt.settings
---@return rt.settings values
---@return table<string, string> sources
function Scene:effective(options) end

---Builds what is to be built now; renders and queries do it when needed.
---@return rt.scene
function Scene:commit() end

---@class rt.tree_query
---@field tracer? string the tracer whose tree is asked; "auto"
---@field group? integer|"top"|"all" 0: the scene's own geometry (default); 1 ...: the instanced scenes; "top": the top level
---@field part? integer which tree of a group that holds things of very different scale; 0
---@field cut? { point: rt.vec3, normal: rt.vec3 } only cells that this plane meets
---@field max_depth? integer cells at this depth are given whole
---@field min_size? number cells whose longest edge is below it are given whole

---@class rt.tree_cell
---@field low number[]
---@field high number[]
---@field depth integer levels below the root
---@field leaves integer 1: the cell is a leaf
---@field empty_leaves integer
---@field deepest integer depth of its deepest leaf
---@field largest integer references of its fullest leaf
---@field references integer
---@field corners? number[][] with a cut: the polygon in which the plane meets it

---The cells of a tree in its own order.
---@param query? rt.tree_query
---@return rt.tree_cell[]
function Scene:tree_cells(query) end

---Leaves counted by depth and by references.
---@param query? rt.tree_query tracer and group count
---@return { depths: table[], sizes: table[] } each a list of { low, high, leaves, references }
function Scene:tree_leaves(query) end

---The box of a tree and its builder's model of costs; nil where no tree stands.
---@param query? rt.tree_query tracer and group count
---@return { low: number[], high: number[], sah_cost: number, cost_traverse: number, cost_intersect: number }?
function Scene:tree_shape(query) end

---The outlines of primitives in a plane. group "top": all instances, placed.
---@param query rt.tree_query cut and group count
---@return rt.buffer lines f32, six numbers a piece: from, to
---@return rt.buffer ids u32, three a piece: primitive, geometry, instance (0xffffffff: none)
function Scene:cut(query) end

---What each ray costs: inner nodes and leaves visited, primitives tested (of a kd-tree or an octree: all that its leaves list).
---@param rays rt.buffer f32, eight numbers a ray: org, tmin, dir, tmax
---@param options? { tracer: string?, group: (integer|"all")?, blind: boolean? } group: that tree alone; blind: the rays see nothing and run through all
---@return { nodes: rt.buffer, leaves: rt.buffer, tests: rt.buffer }
function Scene:ray_costs(rays, options) end

---@class rt.explained_hit
---@field t number
---@field object? rt.shape
---@field name? string the object's
---@field instance_name? string
---@field inst_id? integer
---@field geom_id integer
---@field prim_id integer
---@field position number[]
---@field ng number[] geometric normal
---@field ns number[] shading normal
---@field texture_u number
---@field texture_v number
---@field material_id integer
---@field material? rt.material
---@field material_name? string
---@field color number[]

---@class rt.explained_ray
---@field kind "camera"|"shadow"|"reflect"|"refract"|"diffuse"|"ao"
---@field index integer in the list of rays
---@field parent? integer index of the ray that it comes from
---@field children? rt.explained_ray[]
---@field sample integer
---@field depth integer
---@field org number[]
---@field dir number[]
---@field tmax number
---@field throughput number[] what its light is multiplied by; of a shadow ray the light itself, if nothing were in the way
---@field hit? rt.explained_hit
---@field light? string name of a shadow ray's light
---@field light_id? integer
---@field arrived? boolean shadow and occlusion rays
---@field crossed? integer transparent surfaces that a shadow ray went through
---@field brought integer[] to the film, in its units
---@field unshadowed integer[] with shadows off: what lights brought
---@field nodes integer
---@field leaves integer
---@field tests integer

---@class rt.explained_pixel
---@field x integer
---@field y integer
---@field width integer
---@field height integer
---@field integrator string
---@field samples integer
---@field unit number of the film, a power of two; 0: the integrator shows values
---@field sum integer[] exactly the sum of all that the rays of all samples brought
---@field value number[] the pixel as scene:render gives it
---@field clamped integer
---@field dropped integer
---@field rays rt.explained_ray[] parents before children
---@field roots rt.explained_ray[] the camera rays

---How one pixel came about.
---@param x integer from the left, from 0
---@param y integer from the top
---@param options? rt.settings also: sample, the only one to be told
---@return rt.explained_pixel
function Scene:explain(x, y, options) end

---@class rt.ray
---@field org rt.vec3
---@field dir rt.vec3 of any length
---@field tmin? number in units of dir
---@field tmax? number
---@field mask? integer
---@field time? number 0 to 1, for what moves (0)

---@class rt.hit
---@field t number in units of dir
---@field u number
---@field v number
---@field prim_id integer from 0
---@field geom_id integer from 0
---@field inst_id? integer
---@field position number[]
---@field ng number[] geometric normal
---@field ns number[] shading normal
---@field texture_u number
---@field texture_v number
---@field material_id integer
---@field face_id integer
---@field user_id integer
---@field inst_user_id integer
---@field color number[]
---@field object? rt.shape|rt.instance the description that was hit
---@field name? string its name

---The closest hit, nil on a miss. A buffer of rays (f32; org x y z, tmin, dir x y z, tmax) gives buffers t, u, v, prim_id, geom_id, inst_id.
---@param ray rt.ray|rt.buffer
---@param times? rt.buffer f32, the time of each ray of a buffer
---@return rt.hit|table<string, rt.buffer>|nil
function Scene:intersect(ray, times) end

---All hits along a ray in their order.
---@param ray rt.ray
---@param most? integer 1 ... 1024
---@return rt.hit[]
function Scene:intersect_all(ray, most) end

---Is anything in the way? A buffer of rays gives a buffer of u8.
---@param ray rt.ray|rt.buffer
---@param times? rt.buffer
---@return boolean|rt.buffer
function Scene:occluded(ray, times) end

---Counts, bytes, and statistics of each tree in `trees`.
---@return table
function Scene:info() end

---Hash of all that can change a picture: 32 hexadecimal digits.
---@return string
function Scene:hash() end

---The hash in parts: rest, of all but the looks of materials, and of each material's look with its textures. A scene of the same rest that differs in looks
---of materials that were not touched (stats.touched) renders the same bits.
---@return { rest: string, [integer]: string }
function Scene:looks() end

---Corners of the box around everything finite, nil when there is nothing.
---@return number[]? low
---@return number[]? high
function Scene:bounds() end

---Writes the committed scene as one file for rt.load_snapshot.
---@param path string
---@return rt.scene
function Scene:save(path) end

---Frees the scene now instead of when it is collected. Twice is fine.
function Scene:release() end

---@class rt.job
local Job = {}

---State and progress 0 ... 1, without waiting.
---@return "running"|"done"|"cancelled"|"failed" state
---@return number progress
function Job:poll() end

---Waits at most `seconds` (nil: to the end). A failed job raises why.
---@param seconds? number
---@param each? fun(done: number, job: rt.job)
---@return "running"|"done"|"cancelled" state
---@return number progress
function Job:wait(seconds, each) end

---Ends the render within 100 ms; finished tiles stay.
function Job:cancel() end

---for tile in job:tiles() do: finished tiles in the order of finishing, until the job ends.
---@return fun(): { x: integer, y: integer, width: integer, height: integer }?
function Job:tiles() end

---The image when the job has ended; before, with preview = true, a copy of what is finished, else nil.
---@return rt.image?
function Job:image() end

---@return rt.render_stats
function Job:stats() end

---Cancels and frees the job. Twice is fine.
function Job:release() end

-- ---- camera and lights ----

---@class rt.camera
---@class rt.camera_desc
---@field eye rt.vec3
---@field look_at rt.vec3
---@field up? rt.vec3 ({0, 1, 0})
---@field fov? number vertical, in degrees (50)
---@field projection? "pinhole"|"orthographic" (pinhole)
---@field height? number orthographic: height of the window in scene units (2)
---@field aperture? number radius of the lens in scene units; 0: everything is sharp (0)
---@field f_stop? number instead of aperture: f-number of a lens that shows fov on film of 24 mm height
---@field unit? number for f_stop: metres in a scene unit (1)
---@field focus_distance? number what is sharp, from eye along the view; look_at unless given
---@field focus_at? rt.vec3 instead: a point in the plane that is sharp
---@field blades? integer corners of the lens, 3 to 64; 0: round (0)
---@field blade_rotation? number in degrees; at 0 a corner points up (0)
---@field shutter? number|number[] times from 0 to 1 that the image covers: {open, close}, or close alone; {0, 1} unless given
---@field motion? rt.camera|rt.camera_way the camera at time 1; what is not named stays
---@field name? string

---@class rt.camera_way
---@field eye? rt.vec3
---@field look_at? rt.vec3
---@field up? rt.vec3
---@field fov? number
---@field height? number
---@field aperture? number
---@field f_stop? number
---@field focus_distance? number
---@field focus_at? rt.vec3

---@param desc rt.camera_desc
---@return rt.camera
function rt.camera(desc) end

---@class rt.light
---@class rt.point_light_desc
---@field at rt.vec3
---@field color? rt.vec3 ({1, 1, 1})
---@field intensity? number multiplies color (1)
---@field falloff? "none"|"inverse_square" (none)
---@field samples? integer (0)
---@field name? string

---@param desc rt.point_light_desc
---@return rt.light
function rt.point_light(desc) end

---@class rt.sphere_light_desc
---@field at rt.vec3
---@field radius number soft shadows
---@field color? rt.vec3 ({1, 1, 1})
---@field intensity? number multiplies color (1)
---@field falloff? "none"|"inverse_square" (none)
---@field visible? boolean its body is seen (false)
---@field samples? integer shadow rays a hit; 0: the setting's (0)
---@field name? string

---@param desc rt.sphere_light_desc
---@return rt.light
function rt.sphere_light(desc) end

---@class rt.directional_light_desc
---@field direction rt.vec3 the way the light travels
---@field color? rt.vec3 ({1, 1, 1})
---@field intensity? number multiplies color (1)
---@field samples? integer (0)
---@field name? string

---@param desc rt.directional_light_desc
---@return rt.light
function rt.directional_light(desc) end

-- ---- materials ----

---@class rt.material
---@class rt.classic_desc
---@field color? rt.vec3 linear, 0 ... 1 ({1, 1, 1})
---@field texture? rt.texture_like multiplies color
---@field diffusion? number weight of the diffuse part, 0 ... 1 (1)
---@field reflectiveness? number weight of the mirror, 0 ... 1 (0)
---@field transparency? number weight of the refracted ray, 0 ... 1 (0)
---@field refractiveness? number index of refraction (1)
---@field ambient? number weight of the scene's ambient light, 0 ... 1 (1)
---@field specular? number weight of the highlight (0)
---@field shininess? number exponent of the highlight, 1 ... 100000 (50)
---@field alpha_texture? rt.texture_like cuts holes
---@field alpha_cut? number where its alpha is below this (0.5)
---@field opaque_shadow? boolean a transparent body that casts a full shadow (false)
---@field name? string

---The model of paper 000: diffuse, mirror, glass and highlight, each by its weight.
---@param desc rt.classic_desc
---@return rt.material
function rt.classic(desc) end

---@class rt.emissive_desc
---@field emission rt.vec3 radiance
---@field name? string

---A body that shines and scatters nothing.
---@param desc rt.emissive_desc
---@return rt.material
function rt.emissive(desc) end

---@class rt.texture
---@class rt.texture_desc
---@field file? string relative to the script
---@field image? rt.image instead of a file
---@field wrap? "repeat"|"clamp" (repeat)
---@field linear? boolean values of 8 bits, and of 16 in files, are linear already (false)
---@field nearest? boolean no interpolation (false)
---@field name? string

---@param desc rt.texture_desc
---@return rt.texture
function rt.texture(desc) end

-- ---- shapes ----

---@class rt.shape
---@class rt.shape_desc
---@field material? rt.material
---@field mask? integer seen by rays with (ray mask & mask) ~= 0 (0xffffffff)
---@field user_id? integer yours; in hits (0)
---@field uv_transform? number[] {a, b, c, d, e, f}: u' = a u + b v + c, v' = d u + e v + f ({1, 0, 0, 0, 1, 0})
---@field name? string

---@class rt.sphere_desc : rt.shape_desc
---@field center rt.vec3
---@field radius number

---@param desc rt.sphere_desc
---@return rt.shape
function rt.sphere(desc) end

---@class rt.spheres_desc : rt.shape_desc
---@field centers rt.buffer|number[]|number[][] three numbers a sphere
---@field radii? rt.buffer|number[]
---@field radius? number one for all
---@field colors? rt.buffer|number[]|number[][] multiply the material's
---@field materials? rt.material[] one a sphere

---Many spheres as one shape.
---@param desc rt.spheres_desc
---@return rt.shape
function rt.spheres(desc) end

---@class rt.plane_desc : rt.shape_desc
---@field point rt.vec3
---@field normal rt.vec3
---@field u_axis? rt.vec3 direction of the texture's rows
---@field texture_size? number width of the texture in scene units (1)
---@field texture_height? number else as the picture's shape asks

---@param desc rt.plane_desc
---@return rt.shape
function rt.plane(desc) end

---@class rt.box_desc : rt.shape_desc
---@field low rt.vec3
---@field high rt.vec3

---@param desc rt.box_desc
---@return rt.shape
function rt.box(desc) end

---@class rt.cylinder_desc : rt.shape_desc
---@field from rt.vec3
---@field to rt.vec3
---@field radius number

---@param desc rt.cylinder_desc
---@return rt.shape
function rt.cylinder(desc) end

---@class rt.cone_desc : rt.shape_desc
---@field from rt.vec3
---@field to rt.vec3
---@field radius number at `from`
---@field to_radius? number at `to`; 0 is a tip (0)

---@param desc rt.cone_desc
---@return rt.shape
function rt.cone(desc) end

---Each is a list, which is copied, or a buffer, which is used as it is when the scene is made. Either radii or radius is given.
---@class rt.cylinders_desc : rt.shape_desc
---@field from rt.buffer|number[]|number[][] one end, three numbers a cylinder
---@field to rt.buffer|number[]|number[][] the other, as many; another point than that of `from`
---@field radii? rt.buffer|number[] one a cylinder, greater than 0
---@field radius? number one for all, greater than 0
---@field colors? rt.buffer|number[]|number[][] multiply the material's
---@field materials? rt.material[] one a cylinder

---Many cylinders as one shape.
---@param desc rt.cylinders_desc
---@return rt.shape
function rt.cylinders(desc) end

---Lists and buffers as those of rt.cylinders. Either radii or radius is given, and to_radii, to_radius or neither: then all end in tips. A cone's
---two radii are at least 0, and not both 0.
---@class rt.cones_desc : rt.shape_desc
---@field from rt.buffer|number[]|number[][] one end, three numbers a cone
---@field to rt.buffer|number[]|number[][] the other, as many; another point than that of `from`
---@field radii? rt.buffer|number[] at `from`, one a cone
---@field radius? number at `from`, one for all
---@field to_radii? rt.buffer|number[] at `to`, one a cone
---@field to_radius? number at `to`, one for all (0)
---@field colors? rt.buffer|number[]|number[][] multiply the material's
---@field materials? rt.material[] one a cone

---Many cones, or frusta, as one shape.
---@param desc rt.cones_desc
---@return rt.shape
function rt.cones(desc) end

---@class rt.torus_desc : rt.shape_desc
---@field center rt.vec3
---@field axis rt.vec3
---@field major_radius number
---@field minor_radius number

---@param desc rt.torus_desc
---@return rt.shape
function rt.torus(desc) end

---@class rt.mesh_desc : rt.shape_desc
---@field file? string PLY, OBJ or STL, relative to the script
---@field smooth? boolean make normals where there are none (false)
---@field smooth_angle? number file: edges sharper than this stay, in degrees (60)
---@field ignore_materials? boolean file: do not read an OBJ's MTL (false)
---@field transform? rt.transform|number[] file: baked into the vertices
---@field vertices? rt.buffer|number[]|number[][]
---@field faces? rt.buffer|integer[]|integer[][] three vertex numbers a face: from 1 in lists, from 0 in a buffer
---@field normals? rt.buffer|number[]|number[][]
---@field uvs? rt.buffer|number[]|number[][]
---@field colors? rt.buffer|number[]|number[][]
---@field materials? rt.material[] one a face

---Triangles from a file or from arrays.
---@param desc rt.mesh_desc
---@return rt.shape
function rt.mesh(desc) end

---@class rt.polyhedron_desc : rt.shape_desc
---@field vertices rt.buffer|number[]|number[][]
---@field faces integer[][] corners of each face, vertex numbers from 1

---Faces of any number of corners.
---@param desc rt.polyhedron_desc
---@return rt.shape
function rt.polyhedron(desc) end

---@class rt.group
---@class rt.group_desc
---@field name? string
---@field [integer] rt.item

---A list with a name, and what several instances share.
---@param desc rt.group_desc
---@return rt.group
function rt.group(desc) end

---@class rt.instance
---@class rt.instance_desc
---@field transform? rt.transform|number[] at time 0
---@field motion? rt.transform|number[]|rt.transform[] where it stands at time 1, or at evenly spaced times up to 1
---@field material? rt.material for all of it, instead of its own
---@field mask? integer
---@field user_id? integer
---@field name? string
---@field [integer] rt.shape|rt.group|rt.scene

---Places a shape, a group or a scene; what is placed many times is held and built once.
---@param desc rt.instance_desc
---@return rt.instance
function rt.instance(desc) end

---The first scene, in which what the second has elsewhere is on its way there while the shutter is open: objects that are the same by identity,
---else by name, and the camera. What has no partner stands still, and so do lights.
---@param open rt.scene
---@param close rt.scene
---@return rt.scene
function rt.motion(open, close) end

-- ---- values ----

---@class rt.vec
---@field x number
---@field y number
---@field z number
---@operator add(rt.vec3|number): rt.vec
---@operator sub(rt.vec3|number): rt.vec
---@operator mul(rt.vec3|number): rt.vec
---@operator div(rt.vec3|number): rt.vec
---@operator unm: rt.vec
local Vec = {}

---@param other rt.vec3
---@return number
function Vec:dot(other) end

---@param other rt.vec3
---@return rt.vec
function Vec:cross(other) end

---@return number
function Vec:length() end

---@return rt.vec
function Vec:normalize() end

---This at t = 0, `other` at t = 1.
---@param other rt.vec3
---@param t number
---@return rt.vec
function Vec:lerp(other, t) end

---@return number x
---@return number y
---@return number z
function Vec:unpack() end

---rt.vec(x, y, z), rt.vec {x, y, z} or rt.vec(s).
---@param x number|rt.vec3
---@param y? number
---@param z? number
---@return rt.vec
function rt.vec(x, y, z) end

---A colour as screens have it ("#ff8000", or three numbers from 0 to 1), made linear.
---@param r string|number
---@param g? number
---@param b? number
---@return rt.vec
function rt.srgb(r, g, b) end

---@class rt.transform
---@operator mul(rt.transform): rt.transform
local Transform = {}

---Where a point goes.
---@param p rt.vec3
---@return rt.vec
function Transform:point(p) end

---Where a direction goes.
---@param d rt.vec3
---@return rt.vec
function Transform:direction(d) end

---The identity, or three rows of four numbers.
---@param rows? number[]
---@return rt.transform
function rt.transform(rows) end

---@param x number|rt.vec3
---@param y? number
---@param z? number
---@return rt.transform
function rt.translate(x, y, z) end

---@param x number|rt.vec3 one number scales all axes
---@param y? number
---@param z? number
---@return rt.transform
function rt.scale(x, y, z) end

---@param axis rt.vec3|rt.quat
---@param degrees? number right-handed; a quat needs none
---@return rt.transform
function rt.rotate(axis, degrees) end

---@class rt.buffer
---@field [integer] number
---@operator len: integer
local Buffer = {}

---Writes several values in a row.
---@param first integer from 1
---@param ... number
---@return rt.buffer
function Buffer:set(first, ...) end

---Several values in a row.
---@param first integer from 1
---@param count? integer at most 250
---@return number ...
function Buffer:get(first, count) end

---@param value number
---@return rt.buffer
function Buffer:fill(value) end

---The raw bytes.
---@return string
function Buffer:bytes() end

---@return "f32"|"u32"|"u8"
function Buffer:type() end

---Numbers of one type in one block.
---@param type "f32"|"u32"|"u8"
---@param content integer|number[]|string a count, the numbers, or raw bytes
---@return rt.buffer
function rt.buffer(type, content) end

---@class rt.save_options
---@field format? "png"|"jpg"|"bmp"|"tga"|"hdr" else by the path's ending
---@field exposure? number stops
---@field tone? "none"|"filmic"
---@field bits? integer PNG: 8 or 16
---@field quality? integer JPEG: 1 ... 100
---@field alpha? boolean keep the coverage as alpha; colours stay as they are, in a render mixed with the background's
---@field text? boolean|table<string, string> false: without text entries; a table: these too (PNG, HDR)

---@class rt.image
local Image = {}

---Writes the image; the file is replaced when it is whole. The path is relative to where the program runs.
---@param path string "-" is standard output
---@param options? rt.save_options
---@return rt.image
function Image:save(path, options) end

---Linear red, green, blue and coverage; x and y count from 0, y from the top.
---@param x integer
---@param y integer
---@return number r
---@return number g
---@return number b
---@return number coverage
function Image:pixel(x, y) end

---@param x integer
---@param y integer
---@param r number
---@param g number
---@param b number
---@param coverage? number
function Image:set_pixel(x, y, r, g, b, coverage) end

---@return integer width
---@return integer height
function Image:size() end

---@return { width: integer, height: integer, min: number[], max: number[], mean: number[], coverage: number, not_finite: integer }
function Image:stats() end

---Hash of size and float pixels: 32 hexadecimal digits.
---@return string
function Image:hash() end

---@class rt.compare_options
---@field map? boolean|"difference"|"ssim"|"flip" an image of where they differ: |a - b| (true), 1 - the local similarity, FLIP
---@field flip? boolean compute FLIP; a map of it does, too
---@field ppd? number pixels per degree of the eye's view, for FLIP; 1 to 1000, 67.02 unless told

---How far two images of one size differ. PSNR in dB, SSIM (1: equal), FLIP (0: equal; what a person sees who flips between them).
---@param other rt.image
---@param options? rt.compare_options
---@return { differing: integer, first: integer[]?, max: number, mse: number, psnr: number, ssim: number, flip: number?, map: rt.image? }
function Image:compare(other, options) end

---Another image: the values of this one (the largest of r, g, b) as colours.
---@param name "grey"|"viridis"|"magma"
---@param options? { low: number, high: number } the values of the map's ends, 0 and 1 unless told
---@return rt.image
function Image:color_map(name, options) end

---A text entry that was set; entries of a file are read by rt.image_text.
---@param key string
---@return string?
function Image:text(key) end

---Goes into PNG and HDR files.
---@param key string 1 ... 79 printable ASCII characters
---@param value string without NUL bytes
function Image:set_text(key, value) end

---Another image of another size, resampled in linear light. With one of width and height the shape is kept.
---@param width? integer
---@param height? integer
---@param options? { filter: "auto"|"box"|"mitchell"|"lanczos" }
---@return rt.image
function Image:resize(width, height, options) end

---Sets a rectangle (all of the image unless sides are given) to a colour.
---@param options { x: integer?, y: integer?, width: integer?, height: integer?, color: rt.vec3, coverage: number? }
---@return rt.image
function Image:fill(options) end

---Copies an image into this one, its top left corner at (x, y); what lies outside is left out.
---@param other rt.image
---@param x? integer
---@param y? integer
---@return rt.image
function Image:place(other, x, y) end

---@class rt.label_options
---@field x? number the top left corner, in pixels
---@field y? number
---@field size? number height of a line in pixels, 4 ... 1000
---@field weight? number thickness of the strokes, 1 is regular
---@field color? rt.vec3 white unless given
---@field opacity? number 0 ... 1

---Writes text into the image in the built-in font (ASCII, Latin-1 and a few signs; anything else is an empty box).
---@param text string
---@param options? rt.label_options
---@return rt.image
function Image:label(text, options) end

---Frees the image now. Twice is fine.
function Image:release() end

---Reads a file, or makes an image: black, or by a function of the pixel.
---@param what string|{ width: integer, height: integer, pixel: (fun(x: integer, y: integer): number, number, number)? }
---@return rt.image
function rt.image(what) end

---The text entries of an image file (PNG, HDR; others have none), read without its pixels. Of equal keys the first counts.
---@param path string
---@return table<string, string>
function rt.image_text(path) end

---The linear colour of a value, 0 to 1, in a map whose lightness rises evenly.
---@param name "grey"|"viridis"|"magma"
---@param x number
---@return number[] color
function rt.color_map(name, x) end

---The same as a:compare(b).
---@param a rt.image
---@param b rt.image
---@param options? rt.compare_options
---@return { differing: integer, first: integer[]?, max: number, mse: number, psnr: number, ssim: number, flip: number?, map: rt.image? }
function rt.compare(a, b, options) end

---The width and height in pixels that a label takes.
---@param text string
---@param options? rt.label_options
---@return number width
---@return number height
function rt.label_size(text, options) end

---@class rt.contact_sheet_desc
---@field images (rt.image|string|false)[] images, names of files (read one at a time), or false where there is none
---@field labels? (string|string[])[] text under each image, a string a line; what is too long is cut
---@field columns? integer chosen for a sheet wider than high
---@field width? integer of a cell: 240
---@field height? integer of a cell: by the first image's shape
---@field gap? integer between cells: 16
---@field text_size? number height of a line: 15
---@field title? string above all
---@field background? rt.vec3 white
---@field color? rt.vec3 of the text: nearly black
---@field filter? "auto"|"box"|"mitchell"|"lanczos"

---Many images small on one, each in its own shape with its label.
---@param desc rt.contact_sheet_desc
---@return rt.image
function rt.contact_sheet(desc) end

---Makes the report of a sweep again from its folder: index.html, contact sheets, plots by gnuplot when it is installed.
---@param folder string relative to where the program runs
---@param options? { plots: boolean?, sheets: boolean? } false leaves them out
---@return { page: string, files: string[], notes: string[] } made notes: what could not be done, in sentences
function rt.report(folder, options) end

---A number in [0, 1) that depends on the keys alone: the recommended randomness of scenes.
---@param key number|string
---@param ... number|string
---@return number
function rt.random(key, ...) end

-- ---- animation ----

---@class rt.animation_desc
---@field frames integer how many
---@field scene fun(t: number, frame: integer, seconds: number): rt.scene called for every frame
---@field fps? number frames a second, 24
---@field loop? boolean t = frame / frames, so that the frame after the last is the first; otherwise t = frame / (frames - 1), reaching 1
---@field shutter? number part of a frame's time for which the shutter is open, up to 1: what moves is blurred
---@field name? string
local animation_desc = {}

---@class rt.animation
---@field frames integer
---@field fps number
---@field loop boolean
---@field shutter? number
local Animation = {}

---The scene of a frame, 0 ... frames - 1. An error names the frame.
---@param frame integer
---@return rt.scene
function Animation:scene_at(frame) end

---@param frame number
---@return number t
---@return number seconds
function Animation:time(frame) end

---Scenes by time. `rtray animate` renders it, `rtray render --frame N` one frame of it.
---@param desc rt.animation_desc
---@return rt.animation
function rt.animation(desc) end

---A name ("linear", "smooth", "smoother", "in", "out", "in_out", "step", "overshoot", "bounce"), CSS's cubic-bezier {x1, y1, x2, y2}, or a function.
---@alias rt.easing string|number[]|fun(x: number): number

---The eased x (0 ... 1), or without x the easing's function.
---@param how rt.easing
---@param x? number
---@return number|fun(x: number): number
function rt.ease(how, x) end

---@class rt.keys
---@operator call(number): any
local Keys = {}

---The value at a time; keys(t) is the same.
---@param t number
---@return any
function Keys:at(t) end

---The times of the first and the last key.
---@return number first
---@return number last
function Keys:span() end

---Values at times: { {time, value, ease = how the value comes here}, ..., ease = of all keys, loop = "hold"|"repeat"|"mirror" }. Values are numbers,
---vectors, colours, lists of numbers, rotations (rt.quat), or texts, booleans and descriptions, which hold until the next key.
---@param list table
---@return rt.keys
function rt.keys(list) end

---@class rt.quat
---@operator mul(rt.quat): rt.quat
local Quat = {}

---Where a point goes; q * p is the same.
---@param p rt.vec3
---@return rt.vec
function Quat:point(p) end

---@return rt.quat
function Quat:inverse() end

---@return rt.transform
function Quat:transform() end

---From this rotation at t = 0 to r at t = 1, the shortest way at an even pace.
---@param r rt.quat
---@param t number
---@return rt.quat
function Quat:slerp(r, t) end

---A rotation: none; about an axis by degrees; from one direction to another; or of numbers {x, y, z, w}.
---@param axis? rt.vec3|number[]
---@param degrees? number|rt.vec3
---@return rt.quat
function rt.quat(axis, degrees) end

---@class rt.path
---@operator call(number): rt.vec
local Path = {}

---The point at t, 0 ... 1; path(t) is the same.
---@param t number
---@return rt.vec
function Path:at(t) end

---The unit direction in which the path runs at t.
---@param t number
---@return rt.vec
function Path:direction(t) end

---@return number
function Path:length() end

---A camera at t: rt.camera's keys without eye; look_at may be a function of t, and is what lies ahead when left out.
---@param t number
---@param keys? table
---@return rt.camera
function Path:camera(t, keys) end

---A smooth curve (centripetal Catmull-Rom) through points: { {x, y, z}, ..., closed = false, even = true }. even: equal times are equal lengths.
---@param points table
---@return rt.path
function rt.path(points) end

---@class rt.orbit
---@operator call(number): rt.vec
local Orbit = {}

---The point at t, 0 ... 1; orbit(t) is the same.
---@param t number
---@return rt.vec
function Orbit:at(t) end

---@param t number
---@return rt.vec
function Orbit:direction(t) end

---@return number
function Orbit:length() end

---A camera at t, which looks at the centre unless told otherwise.
---@param t number
---@param keys? table
---@return rt.camera
function Orbit:camera(t, keys) end

---@class rt.orbit_desc
---@field radius number
---@field center? rt.vec3
---@field height? number along the axis
---@field from? number degrees; 0 is on the side of +z, 90 of +x
---@field turns? number of the whole t; negative ones run the other way
---@field axis? rt.vec3
local orbit_desc = {}

---A circle around an axis.
---@param desc rt.orbit_desc
---@return rt.orbit
function rt.orbit(desc) end

---The transform that puts a thing to `from`, its +z towards `to`, its +y upwards.
---@param from rt.vec3
---@param to rt.vec3
---@param up? rt.vec3
---@return rt.transform
function rt.look_at(from, to, up) end

-- ---- scripts ----

---Declares parameters: { name = default } or { name = { default, type =, min =, max =, step =, choices =, help =, label = } }; `sets` names sets of values.
---@param declarations table
---@return table values to be read, by name or by pairs
function rt.params(declarations) end

---Runs a scene script, or reads a mesh (.ply, .obj, .stl), an old scene definition (.sdf) or a saved scene (.rts).
---@param path string
---@param overrides? table<string, any> parameters, as values or texts
---@param options? { set: string?, settings: rt.settings?, seed: integer? }
---@return any value what the script returns
---@return { path: string, params: table[], sets: table<string, table> } run
function rt.load(path, overrides, options) end

---The last line of a script that shall be a program under lua5.4, too.
---@generic T
---@param value T
---@return T
function rt.main(value) end

-- ---- sweeps ----

---@class rt.sweep_desc
---@field scene string|fun(values: table<string, any>): rt.scene a script, or a function of the axes' values (then in this process)
---@field over? table { ior = "1:2.5:0.25", workers = {1, 2} }, axes by name; or { {"ior", "1,2"}, {"workers", "1,2"} } in this order
---@field preset? "jpvm"|"strong"|"weak"|"structures"|"tiles" axes by name
---@field zip? boolean pair the axes' values instead of crossing them
---@field runs? integer of each point; 3 when an axis leaves the picture as it is, else 1
---@field warmup? integer runs of each point before the timed ones
---@field output? string the sweep's folder; without it nothing is kept
---@field in_process? boolean run here instead of in processes of their own
---@field measure? string|fun(image: rt.image, stats: rt.render_stats, point: { label: string, values: table<string, any> }): table<string, number|string|boolean>
---@field reference? string "samples=256": compare each image with the one of the point with these values
---@field parameters? table<string, any> of the script, the same at all points
---@field settings? rt.settings the same at all points
---@field set? string
---@field seed? integer
---@field images? boolean false: keep none
---@field report? boolean false: no page, contact sheets and plots in the folder
---@field timeout? number seconds; a run that takes longer fails
---@field restart? boolean drop what the folder holds
---@field force? boolean keep rows of another machine or version, marked
---@field wait? boolean wait while another process works on the folder
---@field progress? fun(event: { kind: string, done: integer, total: integer, label: string })
---@field note? fun(text: string)
---@field interrupted? fun(): any asked between runs
---@field command? string[] for the record
---@field title? string
---@field dry? boolean plan only: the points, unmeasured

---Renders a scene at every point of a grid of parameters and settings, and measures each; docs/sweep.md describes the results.
---@param desc rt.sweep_desc
---@return table results
function rt.sweep(desc) end

-- ---- the renderer ----

---Before the first scene or image: threads and memory of the renderer.
---@param options { workers: integer?, memory_limit: integer? }
function rt.configure(options) end

---isa: the instruction set of the hot loops, "generic", "sse42", "avx2", "avx512", "avx512_vbmi2" or "neon"; the environment variable RT_ISA lowers it.
---@return { cpus: integer, isa: string, memory_available: integer, workers: integer, memory: integer, memory_peak: integer }
function rt.machine() end

---What reading files and building trees cost since the program began, and what later scenes took over from earlier ones: files by their bytes, trees by their
---geometry and settings. Material libraries of OBJ files are not counted; they are always read.
---@return { files_read: integer, files_kept: integer, trees_built: integer, top_trees_built: integer, trees_kept: integer, trees_refitted: integer, read_seconds: number, build_seconds: number, saved_seconds: number }
function rt.counts() end

---Lets go of what is only kept for later: files and trees, and the memory that renders worked in.
function rt.drop_kept() end

---@return { name: string, help: string }[]
function rt.integrators() end

---@return { name: string, help: string }[]
function rt.tracers() end

---The settings there are, with kind, limits, help and default.
---@return table[]
function rt.settings() end

---What the library has to say goes to this function; nil: to Lua's warn. Returns the one before.
---@param handler? fun(level: "error"|"warning"|"info", message: string)
---@return function?
function rt.on_log(handler) end

return rt
