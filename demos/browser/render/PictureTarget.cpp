// SPDX-License-Identifier: Zlib
#include "demos/browser/render/Gl.h"
#include "demos/browser/render/Renderer.h"

#include <algorithm>

namespace browser
{
struct PictureTarget::Implementation
{
	GlTarget target;
};

PictureTarget::PictureTarget(int width, int height) : m_impl(std::make_unique<Implementation>())
{
	m_impl->target.resize(width, height, GL_RGBA8, false);
}
PictureTarget::~PictureTarget() = default;
unsigned PictureTarget::frame() const { return m_impl->target.frame(); }

Picture PictureTarget::read() const
{
	Picture picture{m_impl->target.width(), m_impl->target.height(), {}};
	const size_t row = size_t(3) * size_t(picture.width);
	std::vector<uint8_t> upward(row * size_t(picture.height));
	glBindFramebuffer(GL_FRAMEBUFFER, frame());
	glPixelStorei(GL_PACK_ALIGNMENT, 1);
	glReadPixels(0, 0, picture.width, picture.height, GL_RGB, GL_UNSIGNED_BYTE, upward.data());
	picture.pixels.resize(upward.size());
	for (int y = 0; y < picture.height; ++y)
		std::copy_n(upward.begin() + std::ptrdiff_t(row) * (picture.height - 1 - y), row, picture.pixels.begin() + std::ptrdiff_t(row) * y);
	return picture;
}
}  // namespace browser
