# librt_belongs(LABEL TARGET...): `ninja tests_LABEL` builds what `ctest -L LABEL` runs, and no more.
function(librt_belongs label)
  if(NOT TARGET tests_${label})
    add_custom_target(tests_${label})
  endif()
  add_dependencies(tests_${label} ${ARGN})
endfunction()
