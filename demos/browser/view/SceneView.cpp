// SPDX-License-Identifier: Zlib
#include "demos/browser/view/SceneView.h"

#include "demos/browser/render/Stopwatch.h"
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
	to.AddRectFilled({middle - 0.5f * size.x - pad, top - 0.4f * pad}, {middle + 0.5f * size.x + pad, top + size.y + 0.4f * pad},
		IM_COL32(25, 30, 38, 215), pad);
	to.AddText({middle - 0.5f * size.x, top}, IM_COL32(255, 255, 255, 255), view.title.c_str());
}

void drawKeys(ImDrawList& to, const std::vector<DrawnKey>& keys, const PixelArea& area)
{
	const float line = ImGui::GetTextLineHeight(), pad = 0.3f * line;
	float y = float(area.height) - 1.25f * line * float(keys.size()) - pad;
	for (const DrawnKey& key : keys)
	{
		const ImVec2 size = ImGui::CalcTextSize(key.text.c_str()), p(float(area.left) + 2 * pad, y);
		to.AddRectFilled(
			{p.x - pad, p.y - 0.2f * pad}, {p.x + 1.6f * line + size.x + pad, p.y + line + 0.4f * pad}, IM_COL32(255, 255, 255, 205), pad);
		to.AddRectFilled({p.x, p.y + 0.1f * line}, {p.x + 1.2f * line, p.y + 0.9f * line},
			ImGui::ColorConvertFloat4ToU32({key.colour.r, key.colour.g, key.colour.b, 1}), 0.5f * pad);
		to.AddText({p.x + 1.6f * line, p.y}, IM_COL32(25, 28, 33, 255), key.text.c_str());
		y += 1.25f * line;
	}
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
		// All views have the same size, so that the renderer keeps its buffers. If the width is odd, they share a column.
		views.push_back({halves[size_t(i)].demo, halves[size_t(i)].title,
			{area.left + i * area.width / count, (area.width + count - 1) / count, area.height}});
	return views;
}

void ScenePainter::paint(const std::vector<SceneView>& views, const DrawChoice& choice, const Camera& camera, Renderer& renderer,
	unsigned target, const RenderQuality& quality, bool texts)
{
	renderer.beginPicture();
	for (const SceneView& view : views)
	{
		if (view.area.empty()) continue;
		double own = 0;
		{
			const Stopwatch watch(own);
			m_list.clear();
			m_list.ground = choice.ground;
			if (view.demo) view.demo->draw(choice, m_list);
		}
		renderer.addOwnTime(own);
		renderer.draw(m_list, camera, target, view.area, quality);
		if (!texts) continue;
		ImDrawList& to = *ImGui::GetBackgroundDrawList();
		drawTexts(to, m_list, camera, view.area);
		drawKeys(to, m_list.keys, view.area);
		if (!view.title.empty()) drawTitle(to, view);
		if (&view != &views.front()) drawDivider(to, view);
	}
}
}  // namespace browser
