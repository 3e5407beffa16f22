std = "lua54"
max_line_length = 150
exclude_files = { "out*/**", "out*" }
files["lua/rt.d.lua"] = { ignore = { "21.", "241", "6.." } } -- declarations alone
files["tests/**/*_spec.lua"] = { std = "+busted" }
files["scenes/*.lua"] = { max_line_length = 180 } -- a scene reads as a table: one object a line
