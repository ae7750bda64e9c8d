#include "renderer/window/picture/plain_shader.h"

#define GLFW_INCLUDE_GLEXT
#include <GLFW/glfw3.h>

#include <array>
#include <utility>

namespace emberline {
namespace {

constexpr const char* kVertices = R"(#version 130
uniform mat4 ProjMtx;
in vec2 Position;
in vec2 UV;
out vec2 place;
void main() {
  place = UV;
  gl_Position = ProjMtx * vec4(Position, 0, 1);
}
)";

// Nothing but the texture: what llvmpipe knows as a copy.
constexpr const char* kPixels = R"(#version 130
uniform sampler2D Texture;
in vec2 place;
out vec4 colour;
void main() { colour = texture(Texture, place); }
)";

// Looks up a function of OpenGL 2.0, which not every system's library exports.
template <typename Function>
Function find(const char* name) {
  return reinterpret_cast<Function>(glfwGetProcAddress(name));
}

struct OpenGl {
  PFNGLCREATESHADERPROC create_shader = find<PFNGLCREATESHADERPROC>("glCreateShader");
  PFNGLSHADERSOURCEPROC shader_source = find<PFNGLSHADERSOURCEPROC>("glShaderSource");
  PFNGLCOMPILESHADERPROC compile_shader = find<PFNGLCOMPILESHADERPROC>("glCompileShader");
  PFNGLDELETESHADERPROC delete_shader = find<PFNGLDELETESHADERPROC>("glDeleteShader");
  PFNGLCREATEPROGRAMPROC create_program = find<PFNGLCREATEPROGRAMPROC>("glCreateProgram");
  PFNGLATTACHSHADERPROC attach_shader = find<PFNGLATTACHSHADERPROC>("glAttachShader");
  PFNGLGETATTRIBLOCATIONPROC attribute = find<PFNGLGETATTRIBLOCATIONPROC>("glGetAttribLocation");
  PFNGLBINDATTRIBLOCATIONPROC bind_attribute =
      find<PFNGLBINDATTRIBLOCATIONPROC>("glBindAttribLocation");
  PFNGLLINKPROGRAMPROC link_program = find<PFNGLLINKPROGRAMPROC>("glLinkProgram");
  PFNGLGETPROGRAMIVPROC get_program = find<PFNGLGETPROGRAMIVPROC>("glGetProgramiv");
  PFNGLDELETEPROGRAMPROC delete_program = find<PFNGLDELETEPROGRAMPROC>("glDeleteProgram");
  PFNGLUSEPROGRAMPROC use_program = find<PFNGLUSEPROGRAMPROC>("glUseProgram");
  PFNGLGETUNIFORMLOCATIONPROC uniform = find<PFNGLGETUNIFORMLOCATIONPROC>("glGetUniformLocation");
  PFNGLGETUNIFORMFVPROC get_uniform = find<PFNGLGETUNIFORMFVPROC>("glGetUniformfv");
  PFNGLUNIFORMMATRIX4FVPROC set_matrix = find<PFNGLUNIFORMMATRIX4FVPROC>("glUniformMatrix4fv");
};

// A context of OpenGL 3.0, which is what the window asks for, has them all.
const OpenGl& opengl() {
  static const OpenGl functions;
  return functions;
}

}  // namespace

void PlainShader::begin(ImDrawList& list) { list.AddCallback(use, this); }

void PlainShader::end(ImDrawList& list) {
  list.AddCallback(ImDrawCallback_ResetRenderState, nullptr);
}

// Instead of ImGui's program, with its vertices and its projection.
void PlainShader::use(const ImDrawList* /*list*/, const ImDrawCmd* command) {
  auto& self = *static_cast<PlainShader*>(command->UserCallbackData);
  const OpenGl& gl = opengl();
  GLint imgui = 0;
  glGetIntegerv(GL_CURRENT_PROGRAM, &imgui);
  if (!std::exchange(self.built_, true)) self.build(unsigned(imgui));
  if (self.program_ == 0) return;
  std::array<float, 16> projection;
  gl.get_uniform(unsigned(imgui), self.projection_of_imgui_, projection.data());
  glDisable(GL_BLEND);
  gl.use_program(self.program_);
  gl.set_matrix(self.projection_, 1, GL_FALSE, projection.data());
}

// Takes its vertices from where `like`, ImGui's program, takes them.
void PlainShader::build(unsigned like) {
  const OpenGl& gl = opengl();
  const unsigned program = gl.create_program();
  for (const auto& [kind, source] :
       {std::pair{GL_VERTEX_SHADER, kVertices}, std::pair{GL_FRAGMENT_SHADER, kPixels}}) {
    const unsigned shader = gl.create_shader(GLenum(kind));
    gl.shader_source(shader, 1, &source, nullptr);
    gl.compile_shader(shader);
    gl.attach_shader(program, shader);
    gl.delete_shader(shader);  // once the program is
  }
  bool alike = true;
  for (const char* name : {"Position", "UV"}) {
    const int place = gl.attribute(like, name);
    alike &= place >= 0;
    if (place >= 0) gl.bind_attribute(program, unsigned(place), name);
  }
  gl.link_program(program);
  GLint linked = GL_FALSE;
  gl.get_program(program, GL_LINK_STATUS, &linked);
  projection_ = linked ? gl.uniform(program, "ProjMtx") : -1;
  projection_of_imgui_ = gl.uniform(like, "ProjMtx");
  if (alike && projection_ >= 0 && projection_of_imgui_ >= 0) {
    program_ = program;
  } else {
    gl.delete_program(program);
  }
}

}  // namespace emberline
