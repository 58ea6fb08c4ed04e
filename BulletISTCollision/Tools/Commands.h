// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Repair/RepairChoice.h"
#include "BulletISTCollision/Core/Tuning/PairTuning.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace ist::tools
{
/// Exit codes; they are a public contract.
enum Exit
{
	kGood = 0,
	kBadInput = 1,
	kUsage = 2,
	kInternal = 3,
	kInterrupted = 130
};

struct BuildArguments
{
	std::string mesh, output;
	int64_t spheres = 0;          ///< 0: not given
	double fill = 0;              ///< 0: not given
	double minRadius = 0;         ///< 0: not given
	double error = 0;             ///< 0: not given
	std::string unit;             ///< empty: not given
	std::string up;               ///< empty: not given
	std::string repair = "auto";  ///< or "ground 2", or "ground 2 y" with an axis of the mesh that `up` turned
	int threads = 0;
	uint64_t seed = 1;
	bool withoutSurface = false, acceptDoubt = false;
	bool json = false, quiet = false;
};

struct InfoArguments
{
	std::string file;
	bool json = false;
};

struct CheckArguments
{
	std::string file, mesh;
	bool json = false;
};

struct ExportArguments
{
	std::string file, spheres, leaves;
};

/// Arguments of `pack` (asset to archive) and `unpack` (archive to asset).
struct PackArguments
{
	std::string input, output;
	bool json = false;
};

struct QueryArguments
{
	std::string fileA, fileB, pose, poses, law = "pressure", pairsOut, surfaceOut;
	double stiffness = 1;
	int level = -1;
	int64_t maxPairs = -1;
	std::optional<double> error;  ///< force tolerance
	bool blend = false, lowerBound = false, gate = false, shuffle = false, json = false;
	int threads = 1, repeat = 1;
};

/// Arguments of `tune`, for two assets or meshes.
struct TuneArguments
{
	std::string fileA, fileB;
	TuneOptions options;
	bool json = false;
};

int runBuild(const BuildArguments& arguments);
int runInfo(const InfoArguments& arguments);
int runCheck(const CheckArguments& arguments);
int runExport(const ExportArguments& arguments);
int runPack(const PackArguments& arguments);
int runUnpack(const PackArguments& arguments);
int runQuery(const QueryArguments& arguments);
int runTune(const TuneArguments& arguments);

/// Prints the message on stderr and returns the code.
int fail(const std::string& message, int code = kBadInput);

/// The tree of an asset. The refusal of a file that may be a mesh says how to make a tree of it.
Result<InnerSphereTree> loadTree(const std::string& path);

/// Prints one line on stderr if a body is so large or small that its unit may be wrong.
void askAboutSize(const std::string& path, double longestSide);

/// Prints one line on stderr for each kind of content of the file that was not imported. Used by commands whose report does not list it.
void warnOfNotTaken(const std::string& path, const Mesh& mesh);
}  // namespace ist::tools
