// Empty: only the precompiled headers matter (CMakeLists.txt).
