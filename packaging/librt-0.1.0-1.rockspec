rockspec_format = "3.0"
package = "librt"
version = "0.1.0-1"
source = { url = "librt-0.1.0.tar.gz", dir = "librt-0.1.0" }
description = {
  summary = "Embeddable ray tracing library: the Lua module rt and the program rtray",
  detailed = [[
Describe a scene in Lua and render it on all cores: kd-trees and octrees, the classic model and path tracing, the same picture bit for bit
for any number of workers.]],
  license = "MIT",
}
dependencies = { "lua >= 5.4, < 5.5" }
build = {
  type = "cmake",
  variables = {
    CMAKE_BUILD_TYPE = "Release",
    CMAKE_INSTALL_PREFIX = "$(PREFIX)",
    CMAKE_INSTALL_LIBDIR = "lib",
    LIBRT_LUA = "ON",
    LIBRT_LUA_MODULE_DIR = "$(LIBDIR)",
    LIBRT_ROCK = "ON",
    BUILD_TESTING = "OFF",
    LIBRT_EXAMPLES = "OFF",
  },
}
