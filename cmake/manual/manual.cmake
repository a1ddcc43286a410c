# The man page and the completions of bash, zsh and fish, from the help texts (cmake/manual/manual.py), in the build folder's share/.
# `cmake --install build/release --prefix DIR --component manual` puts them where man and the shells look.
include(GNUInstallDirs)
find_program(PALPATE_PYTHON NAMES python3 PATHS /usr/bin NO_DEFAULT_PATH REQUIRED)
set(manual_dir ${PROJECT_BINARY_DIR}/share)
set(manual_files ${manual_dir}/man/man1/palpate.1 ${manual_dir}/bash-completion/completions/palpate
    ${manual_dir}/zsh/site-functions/_palpate ${manual_dir}/fish/vendor_completions.d/palpate.fish)
file(GLOB help_texts CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/experiments/commands/help/*.txt)
add_custom_command(
  OUTPUT ${manual_files}
  COMMAND ${PALPATE_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/manual.py ${PROJECT_SOURCE_DIR} ${manual_dir} ${PROJECT_VERSION}
  DEPENDS ${CMAKE_CURRENT_LIST_DIR}/manual.py ${PROJECT_SOURCE_DIR}/palpate ${help_texts}
  VERBATIM)
add_custom_target(palpate_manual ALL DEPENDS ${manual_files})
add_dependencies(programs palpate_manual)
install(DIRECTORY ${manual_dir}/ DESTINATION ${CMAKE_INSTALL_DATADIR} COMPONENT manual)
