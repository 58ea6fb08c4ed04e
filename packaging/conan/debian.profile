# Takes what the recipe requires from Debian: apt-get install libbullet-dev libeigen3-dev libassimp-dev nlohmann-json3-dev
include(default)
[settings]
compiler.cppstd=20
[platform_requires]
bullet3/3.24
eigen/3.4.0
assimp/5.2.5
nlohmann_json/3.11.2
