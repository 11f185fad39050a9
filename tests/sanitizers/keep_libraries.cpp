// Keeps libraries loaded to the end, so that LeakSanitizer can name the one that allocated: what an
// OpenGL driver never frees is known by its library (leaks.txt).
extern "C" int dlclose(void*) { return 0; }
