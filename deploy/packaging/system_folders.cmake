# Run by cpack between installing and packing: moves what Debian keeps outside /usr to where Debian keeps it.
set(root ${CPACK_TEMPORARY_INSTALL_DIRECTORY})
file(MAKE_DIRECTORY ${root}/lib)
file(RENAME ${root}/usr/etc ${root}/etc)
file(RENAME ${root}/usr/lib/systemd ${root}/lib/systemd)
file(GLOB left ${root}/usr/lib/*)
if(NOT left)
  file(REMOVE_RECURSE ${root}/usr/lib)
endif()
