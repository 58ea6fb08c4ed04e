// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "tests/unit/Core/Import/ZipText.h"

/// The model of a 3MF file with one mesh. `attributes` go into its root, `resources` before the mesh, `ofTriangle` into each triangle.
inline std::string modelText(
	const ist::Mesh& mesh, const std::string& attributes, const std::string& resources = "", const std::string& ofTriangle = "")
{
	std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- <model unit=\"foot\"> -->\n<model " + attributes +
		" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
		"xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\"><resources>" +
		resources + "<object id=\"1\" type=\"model\"><mesh><vertices>";
	for (const ist::Vec3& v : mesh.vertices)
		text += "<vertex x=\"" + std::to_string(v.x) + "\" y=\"" + std::to_string(v.y) + "\" z=\"" + std::to_string(v.z) + "\"/>";
	text += "</vertices><triangles>";
	for (const auto& t : mesh.triangles)
		text += "<triangle v1=\"" + std::to_string(t[0]) + "\" v2=\"" + std::to_string(t[1]) + "\" v3=\"" + std::to_string(t[2]) + "\" " +
			ofTriangle + "/>";
	return text + "</triangles></mesh></object></resources><build><item objectid=\"1\"/></build></model>";
}

/// A 3MF file: its model, and further files.
inline std::string packageText(const std::string& model, const std::vector<std::pair<std::string, std::string>>& more = {})
{
	std::vector<std::pair<std::string, std::string>> files = {
		{"[Content_Types].xml", "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\"/>"},
		{"_rels/.rels",
			"<?xml version=\"1.0\"?><Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">"
			"<Relationship Id=\"r1\" Type=\"http://schemas.openxmlformats.org/package/2006/relationships/metadata/thumbnail\" "
			"Target=\"/Metadata/thumbnail.png\"/>"
			"<Relationship Id=\"r0\" Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\" "
			"Target=\"/3D/3dmodel.model\"/></Relationships>"},
		{"3D/3dmodel.model", model}};
	files.insert(files.end(), more.begin(), more.end());
	return zipText(files);
}

/// An AMF file of one mesh. `head`: everything before its object, with the root element last.
inline std::string amfText(const ist::Mesh& mesh, const std::string& head)
{
	std::string text = head + "<object id=\"0\"><mesh><vertices>";
	for (const ist::Vec3& v : mesh.vertices)
		text += "<vertex><coordinates><x>" + std::to_string(v.x) + "</x><y>" + std::to_string(v.y) + "</y><z>" + std::to_string(v.z) +
			"</z></coordinates></vertex>";
	text += "</vertices><volume>";
	for (const auto& [a, b, c] : mesh.triangles)
		text += "<triangle><v1>" + std::to_string(a) + "</v1><v2>" + std::to_string(b) + "</v2><v3>" + std::to_string(c) +
			"</v3></triangle>";
	return text + "</volume></mesh></object></amf>\n";
}

/// An OBJ file of one mesh.
inline std::string objText(const ist::Mesh& mesh)
{
	std::string text;
	for (const ist::Vec3& v : mesh.vertices)
		text += "v " + std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z) + "\n";
	for (const auto& [a, b, c] : mesh.triangles)
		text += "f " + std::to_string(a + 1) + " " + std::to_string(b + 1) + " " + std::to_string(c + 1) + "\n";
	return text;
}
