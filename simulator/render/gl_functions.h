#pragma once

#include <cstddef>

#include "simulator/render/gl_context.h"

namespace uniquadric {

/// Name (without gl), result and parameters of each OpenGL function in use. Their types are spelled out so
/// that no OpenGL header is needed here; gl_functions.cpp proves them equal to those of the OpenGL registry.
#define UNIQUADRIC_GL_FUNCTIONS(X)                                                                    \
  X(AttachShader, void, unsigned, unsigned)                                                           \
  X(BindFramebuffer, void, unsigned, unsigned)                                                        \
  X(BindTextureUnit, void, unsigned, unsigned)                                                        \
  X(BindVertexArray, void, unsigned)                                                                  \
  X(BlitNamedFramebuffer, void, unsigned, unsigned, int, int, int, int, int, int, int, int, unsigned, \
    unsigned)                                                                                         \
  X(CheckNamedFramebufferStatus, unsigned, unsigned, unsigned)                                        \
  X(ClearBufferiv, void, unsigned, int, const int*)                                                   \
  X(ClearBufferfi, void, unsigned, int, float, int)                                                   \
  X(ClearBufferfv, void, unsigned, int, const float*)                                                 \
  X(ClearBufferuiv, void, unsigned, int, const unsigned*)                                             \
  X(ClipControl, void, unsigned, unsigned)                                                            \
  X(CompileShader, void, unsigned)                                                                    \
  X(CreateBuffers, void, int, unsigned*)                                                              \
  X(CreateFramebuffers, void, int, unsigned*)                                                         \
  X(CreateProgram, unsigned)                                                                          \
  X(CreateRenderbuffers, void, int, unsigned*)                                                        \
  X(CreateShader, unsigned, unsigned)                                                                 \
  X(CreateTextures, void, unsigned, int, unsigned*)                                                   \
  X(CreateVertexArrays, void, int, unsigned*)                                                         \
  X(DepthFunc, void, unsigned)                                                                        \
  X(Disable, void, unsigned)                                                                          \
  X(DrawElements, void, unsigned, int, unsigned, const void*)                                         \
  X(Enable, void, unsigned)                                                                           \
  X(EnableVertexArrayAttrib, void, unsigned, unsigned)                                                \
  X(FrontFace, void, unsigned)                                                                        \
  X(GetError, unsigned)                                                                               \
  X(GetProgramInfoLog, void, unsigned, int, int*, char*)                                              \
  X(GetProgramiv, void, unsigned, unsigned, int*)                                                     \
  X(GetString, const unsigned char*, unsigned)                                                        \
  X(GetShaderInfoLog, void, unsigned, int, int*, char*)                                               \
  X(GetShaderiv, void, unsigned, unsigned, int*)                                                      \
  X(LinkProgram, void, unsigned)                                                                      \
  X(NamedBufferStorage, void, unsigned, std::ptrdiff_t, const void*, unsigned)                        \
  X(NamedFramebufferDrawBuffers, void, unsigned, int, const unsigned*)                                \
  X(NamedFramebufferRenderbuffer, void, unsigned, unsigned, unsigned, unsigned)                       \
  X(NamedFramebufferTextureLayer, void, unsigned, unsigned, unsigned, int, int)                       \
  X(NamedRenderbufferStorage, void, unsigned, unsigned, int, int)                                     \
  X(NamedRenderbufferStorageMultisample, void, unsigned, int, unsigned, int, int)                     \
  X(PixelStorei, void, unsigned, int)                                                                 \
  X(PolygonOffset, void, float, float)                                                                \
  X(ReadBuffer, void, unsigned)                                                                       \
  X(ReadPixels, void, int, int, int, int, unsigned, unsigned, void*)                                  \
  X(Scissor, void, int, int, int, int)                                                                \
  X(ShaderSource, void, unsigned, int, const char* const*, const int*)                                \
  X(StencilFunc, void, unsigned, int, unsigned)                                                       \
  X(StencilMask, void, unsigned)                                                                      \
  X(StencilOp, void, unsigned, unsigned, unsigned)                                                    \
  X(TextureParameteri, void, unsigned, unsigned, int)                                                 \
  X(TextureStorage2D, void, unsigned, int, unsigned, int, int)                                        \
  X(TextureStorage3D, void, unsigned, int, unsigned, int, int, int)                                   \
  X(TextureSubImage2D, void, unsigned, int, int, int, int, int, unsigned, unsigned, const void*)      \
  X(Uniform1f, void, int, float)                                                                      \
  X(Uniform1ui, void, int, unsigned)                                                                  \
  X(Uniform3fv, void, int, int, const float*)                                                         \
  X(UniformMatrix4fv, void, int, int, unsigned char, const float*)                                    \
  X(UseProgram, void, unsigned)                                                                       \
  X(VertexArrayAttribBinding, void, unsigned, unsigned, unsigned)                                     \
  X(VertexArrayAttribFormat, void, unsigned, unsigned, int, unsigned, unsigned char, unsigned)        \
  X(VertexArrayElementBuffer, void, unsigned, unsigned)                                               \
  X(VertexArrayVertexBuffer, void, unsigned, unsigned, unsigned, std::ptrdiff_t, int)                 \
  X(Viewport, void, int, int, int, int)

/// OpenGL as a table of functions: `gl.Clear(...)` is glClear.
struct GlFunctions {
#define UNIQUADRIC_GL_MEMBER(name, result, ...) result (*name)(__VA_ARGS__) = nullptr;
  UNIQUADRIC_GL_FUNCTIONS(UNIQUADRIC_GL_MEMBER)
#undef UNIQUADRIC_GL_MEMBER
};

/// The functions of a context that is current. Throws std::runtime_error naming one that is missing.
GlFunctions load_gl_functions(const GlContext& context);

/// Throws std::runtime_error when OpenGL noted an error since the last check; `what` was being done.
void check_gl(const GlFunctions& gl, const char* what);

}  // namespace uniquadric
