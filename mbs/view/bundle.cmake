# Run by CMakeLists.txt: installs the pinned npm packages in the build tree (never in the source tree) and bundles the
# page.  Variables: WEB (sources), WORK (build tree), NPM, NODE.
file(MAKE_DIRECTORY ${WORK})
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
    message(FATAL_ERROR "npm could not install three, uplot and esbuild for the pages (mbs/view/web):\n${text}\n"
                        "They come from the npm registry once and from npm's cache afterwards: check the network "
                        "connection (behind a proxy also NODE_EXTRA_CA_CERTS and `npm config get registry`), "
                        "then build again.")
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
