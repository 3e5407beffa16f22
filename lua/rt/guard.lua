-- Where a host comes between scripts and the machine: the program rtray puts its own functions here (lua/rtray/sandbox.lua). Used as a library the
-- module runs scripts with the state's globals and the rights of the process.

local guard = {}

-- The chunk of the script of run r, or nil and a message.
function guard.load(r)
  return loadfile(r.path, "t")
end

-- A script's file for reading: the file, or nil and the reason.
function guard.open(path)
  return io.open(path, "rb")
end

-- The host is about to open this file itself, for reading or writing; it is no script's wish.
function guard.own(_)
end

-- A script begins (1) or ends (-1, its run).
function guard.depth(_, _)
end

-- Says what goes on from now, as "in the script"; returns what went on before.
function guard.phase(_)
end

-- A run of a sweep begins: limits count from here.
function guard.restart()
end

-- The sentence for what was raised: a limit that ran out explains it better.
function guard.told(raised)
  return raised
end

-- The text entries of an image of opened = { scene, run }, made from the script at `path` with parameters { { name, text } }, set and seed.
function guard.texts(_, _, _)
  return {}
end

-- What a second process of the program is told, so that it guards as this one does.
guard.arguments = {}

return guard
