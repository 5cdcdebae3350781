<?xml version="1.0" encoding="UTF-8"?>
<tileset version="1.10" tiledversion="1.10.0" name=$name_in_xml tilewidth="$tile_width" tileheight="$tile_height" spacing="$spacing" margin="$gutter" tilecount="$count" columns="$columns">
 <image source=$image_in_xml width="$width" height="$height"/>
 <wangsets>
  <wangset name=$name_in_xml type="corner" tile="-1">
$corners_of_tiled  </wangset>
 </wangsets>
</tileset>
