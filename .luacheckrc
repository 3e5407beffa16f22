std = "lua54"
max_line_length = 150
exclude_files = { "out*/**", "out*" }
files["tests/**/*_spec.lua"] = { std = "+busted" }
