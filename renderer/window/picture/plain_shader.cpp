#include "renderer/window/picture/plain_shader.h"

#define GL_GLEXT_PROTOTYPES
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

// Only looks up the texture. llvmpipe recognises this as a copy.
constexpr const char* kPixels = R"(#version 130
uniform sampler2D Texture;
in vec2 place;
out vec4 colour;
void main() { colour = texture(Texture, place); }
)";

}  // namespace

void PlainShader::begin(ImDrawList& list) { list.AddCallback(use, this); }

void PlainShader::end(ImDrawList& list) {
  list.AddCallback(ImDrawCallback_ResetRenderState, nullptr);
}

// ImGui calls this, and then draws with `program_` instead of its own program, but with the same
// vertices and projection.
void PlainShader::use(const ImDrawList* /*list*/, const ImDrawCmd* command) {
  auto& self = *static_cast<PlainShader*>(command->UserCallbackData);
  GLint imgui = 0;
  glGetIntegerv(GL_CURRENT_PROGRAM, &imgui);
  if (!std::exchange(self.built_, true)) self.build(unsigned(imgui));
  if (self.program_ == 0) return;
  std::array<float, 16> projection;
  glGetUniformfv(unsigned(imgui), self.projection_of_imgui_, projection.data());
  glDisable(GL_BLEND);
  glUseProgram(self.program_);
  glUniformMatrix4fv(self.projection_, 1, GL_FALSE, projection.data());
}

// Builds `program_` with the vertex attribute locations of `imgui_program`, ImGui's program.
void PlainShader::build(unsigned imgui_program) {
  const unsigned program = glCreateProgram();
  for (const auto& [kind, source] :
       {std::pair{GL_VERTEX_SHADER, kVertices}, std::pair{GL_FRAGMENT_SHADER, kPixels}}) {
    const unsigned shader = glCreateShader(GLenum(kind));
    glShaderSource(shader, 1, &source, nullptr);
    glCompileShader(shader);
    glAttachShader(program, shader);
    glDeleteShader(shader);  // takes effect when the program is deleted
  }
  bool has_same_attributes = true;
  for (const char* name : {"Position", "UV"}) {
    const int location = glGetAttribLocation(imgui_program, name);
    has_same_attributes &= location >= 0;
    if (location >= 0) glBindAttribLocation(program, unsigned(location), name);
  }
  glLinkProgram(program);
  GLint linked = GL_FALSE;
  glGetProgramiv(program, GL_LINK_STATUS, &linked);
  projection_ = linked ? glGetUniformLocation(program, "ProjMtx") : -1;
  projection_of_imgui_ = glGetUniformLocation(imgui_program, "ProjMtx");
  if (has_same_attributes && projection_ >= 0 && projection_of_imgui_ >= 0) {
    program_ = program;
  } else {
    glDeleteProgram(program);
  }
}

}  // namespace emberline
