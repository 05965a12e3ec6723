# onemap_skipped_test(NAME WHY): in place of a test that cannot run here a skip that says why, never a pass.
function(onemap_skipped_test name why)
  add_test(NAME ${name} COMMAND sh -c "echo 'skipped: ${why}'; exit 77")
endfunction()

# onemap_missing(OUT [FOUND PACKAGE]...): the packages whose variable is false, in one line.
function(onemap_missing out)
  set(missing "")
  while(ARGN)
    list(POP_FRONT ARGN found package)
    if(NOT ${found})
      list(APPEND missing ${package})
    endif()
  endwhile()
  list(JOIN missing " " missing)
  set(${out} "${missing}" PARENT_SCOPE)
endfunction()
