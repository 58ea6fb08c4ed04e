// SPDX-License-Identifier: Zlib
#include "demos/browser/view/Photographer.h"

#include "demos/browser/render/OffscreenContext.h"
#include "demos/browser/view/ChartView.h"
#include "demos/browser/view/Gui.h"
#include "demos/browser/view/SceneView.h"

#include <imgui.h>

namespace browser
{
struct Photographer::Implementation
{
	// Members are destroyed in reverse order, so the context is destroyed last.
	std::unique_ptr<OffscreenContext> context;
	std::unique_ptr<Renderer> renderer;
	std::unique_ptr<PictureTarget> target;
	std::unique_ptr<Gui> gui;
	int width = 0, height = 0;
	ScenePainter painter;
};

Photographer::Photographer(std::unique_ptr<Implementation> implementation) : m_impl(std::move(implementation)) {}
Photographer::~Photographer() = default;

ist::Result<std::unique_ptr<Photographer>> Photographer::make(int width, int height)
{
	if (width < 16 || height < 16 || width > 8192 || height > 8192) return ist::Error{"a picture is 16 to 8192 pixels wide and high"};
	auto context = OffscreenContext::make();
	if (!context) return context.error();
	auto made = std::make_unique<Implementation>();
	made->context = std::move(context).value();
	auto renderer = Renderer::make();
	if (!renderer) return renderer.error();
	made->renderer = std::move(renderer).value();
	made->width = width;
	made->height = height;
	made->target = std::make_unique<PictureTarget>(width, height);
	made->gui = std::make_unique<Gui>(height / 600.0);
	return std::unique_ptr<Photographer>(new Photographer(std::move(made)));
}

const std::string& Photographer::device() const { return m_impl->renderer->device(); }

Picture Photographer::take(BrowsableDemo& demo, bool texts) { return take(demo, demo.firstChoice(), demo.viewpoint(), texts); }

Picture Photographer::take(BrowsableDemo& demo, const DrawChoice& choice, const Viewpoint& view, bool texts)
{
	Implementation& im = *m_impl;
	Camera camera;
	camera.set(view);
	if (texts) im.gui->beginOffscreen(im.width, im.height);
	im.painter.paint(sceneViews(demo, {0, im.width, im.height}), choice, camera, *im.renderer, im.target->frame(), {}, texts);
	if (texts) drawCharts(*ImGui::GetBackgroundDrawList(), demo.charts(), 0, 0, im.width, im.height);
	if (texts) im.gui->end(im.target->frame(), im.width, im.height);
	return im.target->read();
}
}  // namespace browser
