# cmake --install --component program: the program and all that it reads, for a package (docs/install.md). Programs lie in lib/palpate,
# and what they read in share/palpate as it lies in the sources, so that one rule finds both (experiments/files/places.h).
set(palpate_data_dir ${CMAKE_INSTALL_DATADIR}/palpate)
install(TARGETS ${palpate_programs} RUNTIME DESTINATION lib/palpate COMPONENT program)
install(CODE [[
  file(MAKE_DIRECTORY "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/bin")
  file(CREATE_LINK ../lib/palpate/palpate "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/bin/palpate" SYMBOLIC)]] COMPONENT program)

install(DIRECTORY experiments/plans experiments/scenes experiments/schema experiments/training
        DESTINATION ${palpate_data_dir}/experiments COMPONENT program FILES_MATCHING PATTERN "*.yaml" PATTERN "*.json")
install(FILES experiments/fit/candidates.yaml DESTINATION ${palpate_data_dir}/experiments/fit COMPONENT program)
install(DIRECTORY experiments/campaign/workflow DESTINATION ${palpate_data_dir}/experiments/campaign COMPONENT program)
install(DIRECTORY report DESTINATION ${palpate_data_dir} COMPONENT program
        FILES_MATCHING PATTERN "*.py" PATTERN "*.css" PATTERN "__pycache__" EXCLUDE)
install(DIRECTORY results/accepted DESTINATION ${palpate_data_dir}/results COMPONENT program FILES_MATCHING PATTERN "*.json")
install(FILES reference/organ_data.sh DESTINATION ${palpate_data_dir}/reference COMPONENT program)
file(GLOB palpate_descriptions RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS reference/*/contestant.yaml)
foreach(description IN LISTS palpate_descriptions)
  get_filename_component(folder ${description} DIRECTORY)
  install(FILES ${description} DESTINATION ${palpate_data_dir}/${folder} COMPONENT program)
endforeach()
# Without node and npm there are none, and reports say so.
install(DIRECTORY ${PROJECT_BINARY_DIR}/page DESTINATION ${palpate_data_dir} COMPONENT program
        FILES_MATCHING REGEX "/page/(report|live|live_worker|live_engine)\\.(js|css)$" PATTERN "built.txt"
        PATTERN "CMakeFiles" EXCLUDE PATTERN "screenshots" EXCLUDE)

# Documents: what a reader of an installed palpate asks for.
install(FILES README.md ARCHITECTURE.md CHANGELOG.md CITATION.cff LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program FILES_MATCHING PATTERN "*.md" PATTERN "gallery" EXCLUDE)
install(DIRECTORY docs/examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program PATTERN "__pycache__" EXCLUDE)
install(FILES reference/PROTOCOL.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/reference COMPONENT program)

# Which commit it is: asked of git now, or what a source archive says of itself.
install(CODE "
  execute_process(COMMAND \${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR}
    \"-DOUTPUT=\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${palpate_data_dir}/experiments/records/source_version.yaml\"
    -P ${CMAKE_CURRENT_LIST_DIR}/write_source_version.cmake COMMAND_ERROR_IS_FATAL ANY)" COMPONENT program)
