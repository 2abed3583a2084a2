// Nothing: the program's headers are what is compiled (CMakeLists.txt).
