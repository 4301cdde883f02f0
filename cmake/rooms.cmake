# Helpers that give every target of the package the same warnings and floating-point
# rules, and that gather a room's sources by folder.

set(ROOM_WARNINGS -Wall -Wextra -Wconversion)

function(room_compile_options target)
  # Results must not depend on the instruction set: no silent fused multiply-add.
  target_compile_options(${target} PRIVATE ${ROOM_WARNINGS} -ffp-contract=off)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)
  target_include_directories(${target} SYSTEM PUBLIC ${EIGEN3_INCLUDE_DIRS} ${OpenCV_INCLUDE_DIRS})
endfunction()

# room_library(NAME ROOMS folder... LINK library... [MESSAGES])
# MESSAGES: the room includes ROS and the package's generated headers.
function(room_library target)
  cmake_parse_arguments(ARG "MESSAGES" "" "ROOMS;LINK" ${ARGN})
  set(sources)
  foreach(room ${ARG_ROOMS})
    file(GLOB found CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${room}/*.cpp)
    list(APPEND sources ${found})
  endforeach()
  if(NOT sources)
    add_library(${target} INTERFACE)
    target_link_libraries(${target} INTERFACE ${ARG_LINK})
    return()
  endif()
  add_library(${target} SHARED ${sources})
  target_link_libraries(${target} PUBLIC ${ARG_LINK} Threads::Threads)
  room_compile_options(${target})
  if(ARG_MESSAGES)
    room_uses_messages(${target})
  endif()
  install(TARGETS ${target}
    ARCHIVE DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
    LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION})
endfunction()

function(room_uses_messages target)
  target_include_directories(${target} SYSTEM PUBLIC ${catkin_INCLUDE_DIRS})
  foreach(exported ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})
    add_dependencies(${target} ${exported})
  endforeach()
endfunction()

# room_tool(SOURCE library...): one program named after its file.
function(room_tool source)
  get_filename_component(name ${source} NAME_WE)
  add_executable(${name} ${source})
  target_link_libraries(${name} ${ARGN})
  room_compile_options(${name})
  room_uses_messages(${name})
  install(TARGETS ${name} RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
endfunction()
