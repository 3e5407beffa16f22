-- The module's reader and writer of JSON.
return require "rt.json"
