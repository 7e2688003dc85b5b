# Run by CMakeLists.txt: bundles the pages into WORK, from the first of these that there is: the finished bundle of a release
# archive (WEB/bundle), the npm packages pinned in WEB (installed in the build tree, never in the source tree), nothing: then
# the bundle is empty, with a warning.  Variables: WEB (sources), WORK (build tree), NPM, NODE.
set(names page.js page.css report.js report.css)
file(MAKE_DIRECTORY ${WORK})
if(EXISTS ${WEB}/bundle/page.js)
  foreach(name ${names})
    configure_file(${WEB}/bundle/${name} ${WORK}/${name} COPYONLY)
    file(TOUCH ${WORK}/${name})
  endforeach()
  return()
endif()
function(give_up why)
  foreach(name ${names})
    file(WRITE ${WORK}/${name} "")
  endforeach()
  message(WARNING "the programs are built without their pages (flexura view, modes --html, report): ${why}; then configure "
                  "and build again")
endfunction()
if(NOT NODE OR NOT NPM)
  give_up("Node and npm are missing, install Debian's nodejs and npm")
  return()
endif()
# npm ci wipes and refills node_modules, so it runs only when the lock file has changed.
file(SHA256 ${WEB}/package-lock.json wanted)
set(installed "")
if(EXISTS ${WORK}/installed)
  file(READ ${WORK}/installed installed)
endif()
if(NOT installed STREQUAL wanted)
  file(COPY ${WEB}/package.json ${WEB}/package-lock.json DESTINATION ${WORK})
  execute_process(
    COMMAND ${NPM} ci --omit=dev --ignore-scripts --prefer-offline --no-audit --no-fund --loglevel=error
    WORKING_DIRECTORY ${WORK} RESULT_VARIABLE status OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(status)
    give_up("npm could not install three, uplot and esbuild (mbs/view/web):\n${text}\nThey come from the npm registry once and from npm's cache afterwards: check the network connection (behind a proxy also NODE_EXTRA_CA_CERTS and `npm config get registry`)")
    return()
  endif()
  file(WRITE ${WORK}/installed ${wanted})
endif()
file(COPY ${WEB}/bundle.mjs DESTINATION ${WORK})
execute_process(
  COMMAND ${NODE} bundle.mjs ${WORK} ${WEB}
  WORKING_DIRECTORY ${WORK} RESULT_VARIABLE status OUTPUT_VARIABLE text ERROR_VARIABLE text)
if(status)
  message(FATAL_ERROR "the pages' script could not be bundled (mbs/view/web):\n${text}")
endif()
