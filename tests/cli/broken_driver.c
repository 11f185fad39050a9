/* Preloaded under occlab by test_survival.py: an OpenGL that fails as a real one may. BROKEN says how:
 *
 *   hang    the Nth read-back of a texture never returns, as behind a shader that does not end
 *   lost    from the Nth read-back on the context is one that the device had to reset
 *   shader  a line that is no GLSL stands in the Nth shader that is compiled, in front of the line
 *           with BROKEN_LINE
 *
 * BROKEN_AFTER is N, from 1. OpenGL's functions are looked up by dlsym and eglGetProcAddress; both
 * are intercepted. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef unsigned int GLenum;
typedef void (*any_function)(void);

static void* (*real_dlsym)(void*, const char*);
static any_function (*real_get_proc_address)(const char*);
static void (*real_get_texture_image)(unsigned, int, GLenum, GLenum, int, void*);
static GLenum (*real_get_reset_status)(void);
static void (*real_shader_source)(unsigned, int, const char* const*, const int*);
static int read_backs, shaders;

static int is_broken(const char* kind) {
  const char* broken = getenv("BROKEN");
  return broken != NULL && strcmp(broken, kind) == 0;
}

static int after(void) {
  const char* text = getenv("BROKEN_AFTER");
  return text == NULL ? 1 : atoi(text);
}

static void get_texture_image(unsigned texture, int level, GLenum format, GLenum type, int size,
                              void* pixels) {
  ++read_backs;
  while (is_broken("hang") && read_backs >= after()) sleep(1);
  real_get_texture_image(texture, level, format, type, size, pixels);
}

static GLenum get_reset_status(void) {
  if (is_broken("lost") && read_backs >= after()) return 0x8255; /* GL_UNKNOWN_CONTEXT_RESET */
  return real_get_reset_status();
}

static void shader_source(unsigned shader, int count, const char* const* texts, const int* lengths) {
  const char* line = getenv("BROKEN_LINE");
  if (is_broken("shader") && count == 1 && lengths == NULL && line != NULL) {
    const char* at = strstr(texts[0], line);
    if (at != NULL && ++shaders == after()) {
      const char* wrong = "this is not GLSL ";
      char* text = malloc(strlen(texts[0]) + strlen(wrong) + 1);
      const size_t before = (size_t)(at - texts[0]);
      memcpy(text, texts[0], before);
      strcpy(text + before, wrong);
      strcat(text, at);
      const char* changed = text;
      real_shader_source(shader, 1, &changed, NULL);
      free(text);
      return;
    }
  }
  real_shader_source(shader, count, texts, lengths);
}

/* Keeps what was found and returns ours in its place. */
static void* replace(const char* name, void* found) {
  if (found == NULL || name == NULL) return found;
  if (strcmp(name, "glGetTextureImage") == 0) {
    *(void**)&real_get_texture_image = found;
    return (void*)&get_texture_image;
  }
  if (strcmp(name, "glGetGraphicsResetStatus") == 0) {
    *(void**)&real_get_reset_status = found;
    return (void*)&get_reset_status;
  }
  if (strcmp(name, "glShaderSource") == 0) {
    *(void**)&real_shader_source = found;
    return (void*)&shader_source;
  }
  return found;
}

static any_function get_proc_address(const char* name) {
  return (any_function)replace(name, (void*)real_get_proc_address(name));
}

void* dlsym(void* handle, const char* name) {
  if (real_dlsym == NULL) *(void**)&real_dlsym = dlvsym(RTLD_NEXT, "dlsym", "GLIBC_2.2.5");
  void* found = real_dlsym(handle, name);
  if (found != NULL && strcmp(name, "eglGetProcAddress") == 0) {
    *(void**)&real_get_proc_address = found;
    return (void*)&get_proc_address;
  }
  return replace(name, found);
}
