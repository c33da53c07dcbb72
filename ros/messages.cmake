# Generates a message package against the ROS 2 wheels of the Python that runs the build. For desks without apt's
# ROS 2 only: on a car the package comes from apt (COLCON_IGNORE keeps colcon away from this one).
cmake_minimum_required(VERSION 3.24)

find_package(Python3 REQUIRED COMPONENTS Interpreter Development NumPy)

# The wheels' files lie in the environment's prefix, four parents above any of their Python modules.
execute_process(
  COMMAND ${CMAKE_COMMAND} -E env _ROS_WHEELS_BOOTSTRAP_COMPLETE=1 "${Python3_EXECUTABLE}" -c
    "import pathlib, rosidl_adapter as a; print(pathlib.Path(a.__file__).parents[4], end='')"
  OUTPUT_VARIABLE ros_prefix COMMAND_ERROR_IS_FATAL ANY)
set(ENV{AMENT_PREFIX_PATH} "${ros_prefix}")
list(PREPEND CMAKE_PREFIX_PATH "${ros_prefix}")
set(PYTHON_INSTALL_DIR
  "lib/python${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR}/site-packages" CACHE STRING "" FORCE)

# The wheels' targets carry paths of the machine that built them.
function(strip_builders_paths)
  get_property(targets DIRECTORY PROPERTY IMPORTED_TARGETS)
  foreach(target ${targets})
    foreach(property INTERFACE_INCLUDE_DIRECTORIES INTERFACE_LINK_LIBRARIES INTERFACE_SYSTEM_INCLUDE_DIRECTORIES)
      get_target_property(values ${target} ${property})
      if(values)
        list(FILTER values EXCLUDE REGEX "^/opt/python/|^/usr/lib64/")
        set_target_properties(${target} PROPERTIES ${property} "${values}")
      endif()
    endforeach()
  endforeach()
endfunction()

# generate_messages(FILES... DEPENDENCIES packages...)
macro(generate_messages)
  cmake_parse_arguments(messages "" "" "FILES;DEPENDENCIES" ${ARGN})
  find_package(ament_cmake REQUIRED)
  find_package(rosidl_default_generators REQUIRED)
  foreach(dependency ${messages_DEPENDENCIES})
    find_package(${dependency} REQUIRED)
  endforeach()
  strip_builders_paths()
  rosidl_generate_interfaces(${PROJECT_NAME} ${messages_FILES} DEPENDENCIES ${messages_DEPENDENCIES})
  ament_export_dependencies(rosidl_default_runtime)
  ament_package()
endmacro()
