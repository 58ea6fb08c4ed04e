// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/BrowsableDemo.h"
#include "demos/browser/render/Renderer.h"

#include <string>
#include <vector>

namespace browser
{
/// The area in which a demo, or one of its halves, is shown.
struct SceneView
{
	BrowsableDemo* demo = nullptr;  ///< null: an empty scene
	std::string title;
	PixelArea area;
};

/// One view for the whole area, or one of equal size for each half of the demo.
std::vector<SceneView> sceneViews(BrowsableDemo& demo, const PixelArea& area);

/// Draws the views of a demo with one camera.
class ScenePainter
{
public:
	/// Draws the views. `texts`: with forces and titles as text, on the background of the picture that ImGui has begun.
	void paint(const std::vector<SceneView>& views, const DrawChoice& choice, const Camera& camera, Renderer& renderer, unsigned target,
		const RenderQuality& quality, bool texts);

private:
	DrawList m_list;
};
}  // namespace browser
