# What `cmake --install` and `cpack` make of a build: four components, four Debian packages.  The development files are
# those of mbs/library.
install(TARGETS flexura RUNTIME DESTINATION bin COMPONENT runtime)
install(FILES LICENSE README.md CHANGELOG.md DESTINATION share/doc/flexura COMPONENT runtime)
# Manual pages (of each command), completion and the examples; the programs themselves tell the first two.
install(CODE "execute_process(COMMAND bash ${CMAKE_SOURCE_DIR}/tests/setup/shell_files.sh ${CMAKE_BINARY_DIR}/bin/flexura ${CMAKE_BINARY_DIR}/share COMMAND_ERROR_IS_FATAL ANY)"
        COMPONENT runtime)
install(DIRECTORY ${CMAKE_BINARY_DIR}/share/ DESTINATION share COMPONENT runtime)
install(DIRECTORY cases DESTINATION share/flexura COMPONENT runtime USE_SOURCE_PERMISSIONS)
install(TARGETS flexura-reduce flexura-mesh flexura-import flexura-assembly RUNTIME DESTINATION bin COMPONENT reduction)
install(DIRECTORY mbs/python/flexura DESTINATION lib/python3/dist-packages COMPONENT python FILES_MATCHING PATTERN "*.py" PATTERN "py.typed")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME flexura)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "the Flexura developers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "flexible bodies from CAD in multibody simulation")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL runtime reduction development python)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
# What the programs link is found by dpkg-shlibdeps; headers and modules are named.
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME flexura)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS flexura-reduce)
set(CPACK_DEBIAN_REDUCTION_PACKAGE_NAME flexura-reduce)
set(CPACK_DEBIAN_REDUCTION_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_REDUCTION_PACKAGE_DEPENDS "flexura (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_REDUCTION_PACKAGE_RECOMMENDS libopenblas0-pthread)  # the default BLAS is five times slower
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libflexura-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    "cmake, pkg-config, libeigen3-dev, libfmt-dev, libtomlplusplus-dev, nlohmann-json3-dev, libsundials-dev, libsuitesparse-dev, libhdf5-dev, libxxhash-dev")
# What find_package(Flexura COMPONENTS reduce) needs beside.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_RECOMMENDS
    "flexura-reduce, libpetsc-real-dev, slepc-dev, libopenmpi-dev, libmetis-dev, libopenblas-dev, zlib1g-dev")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-flexura)
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3, python3-numpy, python3-h5py, flexura")
include(CPack)
