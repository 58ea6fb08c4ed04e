// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Importer/AssimpImport.h"
#include "BulletISTCollision/Importer/Importer.h"

int main(int argc, char** argv) { return ist::runImporter(argc, argv, ist::importByAssimp); }
