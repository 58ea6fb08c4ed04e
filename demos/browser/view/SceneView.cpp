// SPDX-License-Identifier: Zlib
#include "demos/browser/view/SceneView.h"

#include "demos/browser/view/Gui.h"

#include <imgui.h>

namespace browser
{
namespace
{
void drawTitle(ImDrawList& to, const SceneView& view)
{
	const ImVec2 size = ImGui::CalcTextSize(view.title.c_str());
	const float middle = float(view.area.left) + 0.5f * float(view.area.width), top = 0.6f * size.y, pad = 0.4f * size.y;
	to.AddRectFilled({middle - 0.5f * size.x - pad, top - 0.4f * pad}, {middle + 0.5f * size.x + pad, top + size.y + 0.4f * pad}, IM_COL32(25, 30, 38, 215), pad);
	to.AddText({middle - 0.5f * size.x, top}, IM_COL32(255, 255, 255, 255), view.title.c_str());
}

void drawDivider(ImDrawList& to, const SceneView& view)
{
	const float x = float(view.area.left);
	to.AddLine({x, 0}, {x, float(view.area.height)}, IM_COL32(25, 30, 38, 215), 0.12f * ImGui::GetTextLineHeight());
}
}  // namespace

std::vector<SceneView> sceneViews(BrowsableDemo& demo, const PixelArea& area)
{
	const auto halves = demo.halves();
	if (halves.empty()) return {{&demo, "", area}};
	std::vector<SceneView> views;
	const int count = int(halves.size());
	for (int i = 0; i < count; ++i)
		// Alike in size, so that the renderer keeps its buffers; where the width is odd they share a column.
		views.push_back({halves[size_t(i)].demo, halves[size_t(i)].title, {area.left + i * area.width / count, (area.width + count - 1) / count, area.height}});
	return views;
}

void ScenePainter::paint(const std::vector<SceneView>& views, const DrawChoice& choice, const Camera& camera, Renderer& renderer, unsigned target,
						 const RenderQuality& quality, bool texts)
{
	renderer.beginPicture();
	for (const SceneView& view : views)
	{
		if (view.area.empty()) continue;
		m_list.clear();
		m_list.ground = choice.ground;
		if (view.demo) view.demo->draw(choice, m_list);
		renderer.draw(m_list, camera, target, view.area, quality);
		if (!texts) continue;
		ImDrawList& to = *ImGui::GetBackgroundDrawList();
		drawTexts(to, m_list, camera, view.area);
		if (!view.title.empty()) drawTitle(to, view);
		if (&view != &views.front()) drawDivider(to, view);
	}
}
}  // namespace browser
