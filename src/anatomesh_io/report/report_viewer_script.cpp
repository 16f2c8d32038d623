#include "anatomesh_io/report/report_assets.h"

namespace anatomesh {

// Plain WebGL 2. Reads the scene (report_scene.h) from the page's script elements, builds vertex buffers of 24 bytes a
// vertex (position, normal, colour, distance to the drawn edges) and draws them with one program; the contours
// with another. Parallel projection, so that lengths can be read off.
const std::string_view report_viewer_script = R"js(
'use strict';
(function(){
const $=id=>document.getElementById(id),stage=$('stage');
const say=text=>{const m=$('message');m.textContent=text;m.hidden=false;};
const info=JSON.parse($('scene').textContent);
const bytes=id=>{const s=atob($(id).textContent),n=s.length,b=new Uint8Array(n);for(let i=0;i<n;i++)b[i]=s.charCodeAt(i);return b;};
const canvas=$('view');
const gl=canvas.getContext('webgl2',{antialias:true,alpha:true,premultipliedAlpha:false});
if(!gl){say('The 3D view needs WebGL 2, which this browser does not offer. Everything else on this page is complete.');return;}

// The scene: points on a 16 bit grid over the box, indices of three bytes.
const low=info.low,step=info.step;
const pts=b=>{const v=new DataView(b.buffer),n=b.length/6,p=new Float32Array(3*n);
  for(let i=0;i<3*n;i++)p[i]=low[i%3]+step[i%3]*v.getUint16(2*i,true);return p;};
const idx=b=>{const n=b.length/3,r=new Uint32Array(n);for(let i=0,j=0;i<n;i++,j+=3)r[i]=b[j]|b[j+1]<<8|b[j+2]<<16;return r;};
const u16=b=>{const v=new DataView(b.buffer),r=new Uint16Array(b.length/2);for(let i=0;i<r.length;i++)r[i]=v.getUint16(2*i,true);return r;};
const P=pts(bytes('points')),cells=idx(bytes('cells')),cellRegion=u16(bytes('cell-regions'));
const tris=idx(bytes('triangles')),sides=u16(bytes('sides')),lines=pts(bytes('contours')),lineSize=idx(bytes('contour-sizes'));
const lineStructure=u16(bytes('contour-structures'));
const center=[0,1,2].map(i=>low[i]+step[i]*32767.5),extent=[0,1,2].map(i=>step[i]*65535);
const radius=Math.max(1e-6,Math.hypot(...extent)/2);

// Vectors.
const dot=(a,b)=>a[0]*b[0]+a[1]*b[1]+a[2]*b[2];
const cross=(a,b)=>[a[1]*b[2]-a[2]*b[1],a[2]*b[0]-a[0]*b[2],a[0]*b[1]-a[1]*b[0]];
const unit=a=>{const l=Math.hypot(a[0],a[1],a[2])||1;return[a[0]/l,a[1]/l,a[2]/l];};
const at=i=>[P[3*i],P[3*i+1],P[3*i+2]];

// Structures: what is shown, and in which colour.
const shown=info.structures.map(()=>true);
const regionShown=r=>info.regions[r].some(s=>shown[s]);
const regionColor=r=>{const s=info.regions[r].find(i=>shown[i]);return s===undefined?[200,200,200]:info.structures[s].color;};

// State.
const state={mode:'surface',axis:2,place:.5,flip:false,edges:false,contours:false,color:'structure',turn:-.6,tilt:.28,zoom:1,pan:[0,0]};
const plane={n:[0,0,1],d:0};

// Program for facets and for lines.
function program(vertex,fragment){
  const p=gl.createProgram();
  for(const[type,text]of[[gl.VERTEX_SHADER,vertex],[gl.FRAGMENT_SHADER,fragment]]){
    const s=gl.createShader(type);gl.shaderSource(s,'#version 300 es\n'+text);gl.compileShader(s);gl.attachShader(p,s);}
  gl.bindAttribLocation(p,0,'position');gl.bindAttribLocation(p,1,'normal');gl.bindAttribLocation(p,2,'color');gl.bindAttribLocation(p,3,'bary');
  gl.linkProgram(p);
  if(!gl.getProgramParameter(p,gl.LINK_STATUS))throw new Error(gl.getProgramInfoLog(p)||'WebGL');
  return{p,at:name=>gl.getUniformLocation(p,name)};
}
const head='precision highp float;uniform mat4 view;uniform vec4 clip;uniform float nudge;';
let facets,segments;
try{
facets=program(head+`in vec3 position;in vec3 normal;in vec3 color;in vec3 bary;uniform mat3 turn;
out vec3 n,c,b;out float side;
void main(){gl_Position=view*vec4(position,1.);gl_Position.z-=nudge;n=turn*normal;c=color;b=bary;side=dot(clip.xyz,position)-clip.w;}`,
`precision highp float;in vec3 n,c,b;in float side;uniform float clipping,edges,flatness;uniform vec3 edgeColor;out vec4 o;
void main(){if(clipping>.5&&side>0.)discard;
vec3 m=normalize(n);bool back=m.z<0.;if(back)m=-m;
vec3 base=pow(c,vec3(2.2));
float key=max(dot(m,normalize(vec3(-.35,.55,.76))),0.),fill=max(dot(m,normalize(vec3(.8,-.1,.6))),0.);
float shine=pow(max(dot(m,normalize(vec3(-.2,.3,.93))),0.),28.);
vec3 lit=base*(.2+.12*m.y+.74*key+.2*fill)+vec3(.05)*shine;
if(back)lit=base*vec3(.42,.36,.34)*(.35+.65*m.z);
lit=mix(lit,base*.92,flatness);
vec3 w=fwidth(b),t=smoothstep(w*.15,w*.85,b);float e=1.-min(t.x,min(t.y,t.z));
o=vec4(mix(pow(lit,vec3(1./2.2)),edgeColor,e*edges),1.);}`);
segments=program(head+`in vec3 position;in vec3 color;out vec3 c;out float side;
void main(){gl_Position=view*vec4(position,1.);gl_Position.z-=nudge;c=color;side=dot(clip.xyz,position)-clip.w;}`,
`precision highp float;in vec3 c;in float side;uniform float clipping;out vec4 o;void main(){if(clipping>.5&&side>0.)discard;o=vec4(c,1.);}`);
}catch(error){say('The 3D view could not start ('+error.message+'). Everything else on this page is complete.');return;}
gl.enable(gl.DEPTH_TEST);gl.depthFunc(gl.LEQUAL);

// A growing vertex buffer: position f32 x 3, normal i8 x 4, colour u8 x 4, edge distance u8 x 4.
class Mesh{
  constructor(){this.vao=gl.createVertexArray();this.buffer=gl.createBuffer();this.count=0;
    gl.bindVertexArray(this.vao);gl.bindBuffer(gl.ARRAY_BUFFER,this.buffer);
    [[0,3,gl.FLOAT,false,0],[1,3,gl.BYTE,true,12],[2,3,gl.UNSIGNED_BYTE,true,16],[3,3,gl.UNSIGNED_BYTE,true,20]]
      .forEach(([i,n,t,norm,o])=>{gl.enableVertexAttribArray(i);gl.vertexAttribPointer(i,n,t,norm,24,o);});}
  begin(room){this.bytes=new ArrayBuffer(24*Math.max(room,64));this.open();this.count=0;}
  open(){this.f=new Float32Array(this.bytes);this.i=new Int8Array(this.bytes);this.u=new Uint8Array(this.bytes);this.room=this.bytes.byteLength/24;}
  add(p,n,c,b){
    if(this.count===this.room){const more=new ArrayBuffer(2*this.bytes.byteLength);new Uint8Array(more).set(this.u);this.bytes=more;this.open();}
    const k=this.count++,f=6*k,o=24*k;
    this.f[f]=p[0];this.f[f+1]=p[1];this.f[f+2]=p[2];
    for(let j=0;j<3;j++){this.i[o+12+j]=Math.round(127*n[j]);this.u[o+16+j]=c[j];this.u[o+20+j]=b[j];}}
  end(){gl.bindBuffer(gl.ARRAY_BUFFER,this.buffer);gl.bufferData(gl.ARRAY_BUFFER,new Uint8Array(this.bytes,0,24*this.count),gl.DYNAMIC_DRAW);this.bytes=this.f=this.i=this.u=null;}
  draw(kind){if(this.count){gl.bindVertexArray(this.vao);gl.drawArrays(kind,0,this.count);}}
}
const surface=new Mesh(),cut=new Mesh(),strokes=new Mesh();
const corner=[[255,0,0],[0,255,0],[0,0,255]];

// The facets between a shown and a hidden region, smooth where they bound the outside.
function buildSurface(){
  const visible=info.regions.map((_,r)=>r>0&&regionShown(r)),normals=new Float32Array(P.length),count=tris.length/3;
  const facet=t=>{const a=visible[sides[2*t]],b=visible[sides[2*t+1]];return a===b?0:a?1:-1;};
  for(let t=0;t<count;t++){const s=facet(t);if(!s)continue;
    const i=tris[3*t],j=tris[3*t+1],k=tris[3*t+2],a=at(i),n=cross(sub(at(j),a),sub(at(k),a));
    for(const v of[i,j,k])for(let x=0;x<3;x++)normals[3*v+x]+=s*n[x];}
  surface.begin(3*count);
  for(let t=0;t<count;t++){const s=facet(t);if(!s)continue;
    const color=regionColor(s>0?sides[2*t]:sides[2*t+1]);
    for(let e=0;e<3;e++){const v=tris[3*t+(s>0?e:2-e)];surface.add(at(v),unit([normals[3*v],normals[3*v+1],normals[3*v+2]]),color,corner[e]);}}
  surface.end();
}
const sub=(a,b)=>[a[0]-b[0],a[1]-b[1],a[2]-b[2]];

// Circumradius / shortest edge of a cell, and its colour from blue (0.6) over yellow to red (2 and more).
function radiusEdge(p){
  const a=sub(p[1],p[0]),b=sub(p[2],p[0]),c=sub(p[3],p[0]),bc=cross(b,c),ca=cross(c,a),ab=cross(a,b);
  const A=dot(a,a),B=dot(b,b),C=dot(c,c),R=Math.hypot(...[0,1,2].map(i=>A*bc[i]+B*ca[i]+C*ab[i]))/(2*Math.abs(dot(a,bc))||1e-30);
  let s=Infinity;for(let i=0;i<4;i++)for(let j=0;j<i;j++)s=Math.min(s,Math.hypot(...sub(p[i],p[j])));
  return R/s;
}
const ramp=[[58,102,168],[112,178,196],[238,226,160],[226,140,78],[178,42,46]];
function rampColor(v){const x=Math.min(.9999,Math.max(0,(v-.6)/1.4))*4,i=Math.floor(x),f=x-i;return[0,1,2].map(k=>Math.round(ramp[i][k]*(1-f)+ramp[i+1][k]*f));}
const cellColor=(c,p)=>state.color==='quality'?rampColor(radiusEdge(p)):regionColor(cellRegion[c]);

// The plane goes through the box along its normal; what lies beyond it is cut away.
function setPlane(){
  let n=state.axis<3?[0,1,2].map(i=>i===state.axis?1:0):state.facing;
  const reach=state.axis<3?extent[state.axis]/2:radius;
  const d=dot(n,center)+(2*state.place-1)*reach*1.0001;
  plane.value=state.axis<3?d:(2*state.place-1)*reach;
  plane.n=state.flip?n.map(x=>-x):n;plane.d=state.flip?-d:d;
}
// What is nearer to the eye than the plane is cut away.
function faceMe(){state.flip=state.axis<3&&camera()[2][state.axis]<0;}
const four=[[1,2,3],[0,3,2],[0,1,3],[0,2,1]];
function buildCut(){
  setPlane();
  cut.begin(4096);let hit=0;
  if(state.mode!=='surface'){
    const n=plane.n,points=P.length/3,side=new Float32Array(points);
    for(let i=0;i<points;i++)side[i]=n[0]*P[3*i]+n[1]*P[3*i+1]+n[2]*P[3*i+2]-plane.d;
    const visible=info.regions.map((_,r)=>r>0&&regionShown(r));
    for(let c=0,k=0;c<cellRegion.length;c++,k+=4){
      const s0=side[cells[k]]>0,s1=side[cells[k+1]]>0,s2=side[cells[k+2]]>0,s3=side[cells[k+3]]>0;
      if((s0===s1&&s1===s2&&s2===s3)||!visible[cellRegion[c]])continue;
      hit++;
      if(state.mode==='section')section(c,k,side);else wholeCell(c,k);
    }
  }
  cut.end();
  $('cut-note').textContent=state.mode==='surface'?'':planeName()+', '+hit.toLocaleString('en')+' tetrahedra cut';
}
function planeName(){const v=(Math.round(10*plane.value)/10+0).toFixed(1)+' mm';return state.axis<3?'plane '+'xyz'[state.axis]+' = '+v:'plane facing you, '+v+' from the middle';}
// The polygon in which the plane cuts a cell: a triangle, or a quadrangle in cyclic order.
function section(c,k,side){
  const above=[],below=[];for(let i=0;i<4;i++)(side[cells[k+i]]>0?above:below).push(cells[k+i]);
  const mix=(i,j)=>{const t=side[i]/(side[i]-side[j]),a=at(i),b=at(j);return[a[0]+t*(b[0]-a[0]),a[1]+t*(b[1]-a[1]),a[2]+t*(b[2]-a[2])];};
  const color=cellColor(c,[0,1,2,3].map(i=>at(cells[k+i])));
  if(above.length===2){const[a,b]=above,[d,e]=below,q=[mix(a,d),mix(a,e),mix(b,e),mix(b,d)];
    [0,1,2,0,2,3].forEach((v,i)=>cut.add(q[v],plane.n,color,quarter[i]));
  }else{const lone=above.length===1?above[0]:below[0],rest=above.length===1?below:above;
    rest.forEach((v,i)=>cut.add(mix(lone,v),plane.n,color,corner[i]));}
}
// Distances to the edges in the triangles q0 q1 q2 and q0 q2 q3; from the diagonal q0 q2, which is no edge, always far.
const quarter=[[255,255,0],[0,255,0],[0,255,255],[255,255,0],[0,255,255],[0,255,0]];
function wholeCell(c,k){
  const p=[0,1,2,3].map(i=>at(cells[k+i])),m=[0,1,2].map(x=>(p[0][x]+p[1][x]+p[2][x]+p[3][x])/4);
  const color=cellColor(c,p),q=p.map(v=>[0,1,2].map(x=>m[x]+.9*(v[x]-m[x])));
  for(const f of four){const n=unit(cross(sub(q[f[1]],q[f[0]]),sub(q[f[2]],q[f[0]])));f.forEach((v,i)=>cut.add(q[v],n,color,corner[i]));}
}
function buildContours(){
  strokes.begin(2*lines.length/3);let first=0;
  for(let c=0;c<lineSize.length;c++){const n=lineSize[c];
    if(shown[lineStructure[c]])for(let i=0;i<n;i++)for(const j of[i,(i+1)%n])
      strokes.add([lines[3*(first+j)],lines[3*(first+j)+1],lines[3*(first+j)+2]],[0,0,1],ink.contour,[0,0,0]);
    first+=n;}
  strokes.end();
}

// Camera: turned about the body's axis (z, superior), then tilted. Rows: right, up, towards the eye.
function camera(){
  const c=Math.cos(state.turn),s=Math.sin(state.turn),ct=Math.cos(state.tilt),st=Math.sin(state.tilt);
  const right=[c,s,0],eye=[s*ct,-c*ct,st];return[right,cross(eye,right),eye];
}
function pixelsPerMm(){return state.zoom*Math.min(canvas.clientWidth,canvas.clientHeight)/(2*radius)*1.32;}
const ink={};
function readColors(){const dark=matchMedia('(prefers-color-scheme: dark)').matches;ink.edge=dark?[.05,.07,.09]:[.1,.13,.17];ink.contour=dark?[255,196,84]:[196,58,22];}
let pending=false;
function draw(){if(!pending){pending=true;requestAnimationFrame(paint);}}
function paint(){
  pending=false;
  const ratio=window.devicePixelRatio||1,w=Math.round(canvas.clientWidth*ratio),h=Math.round(canvas.clientHeight*ratio);
  if(canvas.width!==w||canvas.height!==h){canvas.width=w;canvas.height=h;}
  gl.viewport(0,0,w,h);gl.clearColor(0,0,0,0);gl.clear(gl.COLOR_BUFFER_BIT|gl.DEPTH_BUFFER_BIT);
  const rows=camera(),k=pixelsPerMm(),sx=2*k/canvas.clientWidth,sy=2*k/canvas.clientHeight,sz=-.5/radius,m=new Float32Array(16);
  [sx,sy,sz].forEach((s,i)=>{for(let x=0;x<3;x++)m[4*x+i]=s*rows[i][x];m[12+i]=-s*dot(rows[i],center);});
  m[12]+=sx*state.pan[0];m[13]+=sy*state.pan[1];m[15]=1;
  const turn=new Float32Array(9);for(let i=0;i<3;i++)for(let x=0;x<3;x++)turn[3*x+i]=rows[i][x];
  const clipping=state.mode==='surface'?0:1;
  for(const q of[facets,segments]){gl.useProgram(q.p);gl.uniformMatrix4fv(q.at('view'),false,m);gl.uniform4f(q.at('clip'),...plane.n,plane.d);
    gl.uniform1f(q.at('clipping'),clipping);gl.uniform1f(q.at('nudge'),0);}
  gl.useProgram(facets.p);gl.uniformMatrix3fv(facets.at('turn'),false,turn);gl.uniform3f(facets.at('edgeColor'),...ink.edge);
  gl.uniform1f(facets.at('flatness'),0);gl.uniform1f(facets.at('edges'),state.edges?.55:0);surface.draw(gl.TRIANGLES);
  if(clipping){gl.uniform1f(facets.at('clipping'),0);gl.uniform1f(facets.at('edges'),.75);gl.uniform1f(facets.at('flatness'),state.mode==='section'?.75:.15);
    gl.uniform1f(facets.at('nudge'),state.mode==='section'?2e-5:0);cut.draw(gl.TRIANGLES);}
  if(state.contours){gl.useProgram(segments.p);gl.uniform1f(segments.at('nudge'),6e-4);strokes.draw(gl.LINES);}
  compass(rows);scale(k);
}
// Patient axes (LPS): towards left, posterior, superior.
function compass(rows){
  let svg='';
  [['L','R'],['P','A'],['S','I']].map((names,i)=>({names,x:24*rows[0][i],y:-24*rows[1][i],z:rows[2][i]})).sort((a,b)=>a.z-b.z).forEach(a=>{
    const name=info.patient?a.names[0]:'xyz'['LPS'.indexOf(a.names[0])];
    svg+=`<line x1="40" y1="40" x2="${40+a.x}" y2="${40+a.y}" stroke="var(--soft)" stroke-width="1.6" opacity="${.6+.4*a.z}"/>`+
      `<text x="${40+1.42*a.x}" y="${44+1.42*a.y}" text-anchor="middle" fill="var(--ink)">${name}</text>`;});
  $('compass').innerHTML=svg;
}
function scale(k){
  const want=90/k,ten=Math.pow(10,Math.floor(Math.log10(want))),mm=[5,2,1].map(f=>f*ten).find(f=>f<=want)||ten;
  $('scale').style.width=mm*k+'px';$('scale-text').textContent=+mm.toPrecision(2)+' mm';
}

// Hands on.
const held=new Map();let spread=0;
canvas.addEventListener('pointerdown',e=>{held.set(e.pointerId,[e.clientX,e.clientY]);canvas.setPointerCapture(e.pointerId);spread=0;});
for(const name of['pointerup','pointercancel'])canvas.addEventListener(name,e=>{held.delete(e.pointerId);spread=0;});
canvas.addEventListener('pointermove',e=>{
  const last=held.get(e.pointerId);if(!last)return;
  const dx=e.clientX-last[0],dy=e.clientY-last[1];held.set(e.pointerId,[e.clientX,e.clientY]);
  if(held.size>1){const[a,b]=[...held.values()],now=Math.hypot(a[0]-b[0],a[1]-b[1]);if(spread)zoom(now/spread,0,0);spread=now;move(dx/2,dy/2);}
  else if(e.shiftKey||e.buttons&6)move(dx,dy);
  else{state.turn-=dx*.008;state.tilt=Math.max(-1.5707,Math.min(1.5707,state.tilt+dy*.008));}
  draw();});
canvas.addEventListener('contextmenu',e=>e.preventDefault());
canvas.addEventListener('wheel',e=>{e.preventDefault();const r=canvas.getBoundingClientRect();
  zoom(Math.exp(-Math.sign(e.deltaY)*Math.min(60,Math.abs(e.deltaY))*.0025),e.clientX-r.left-r.width/2,r.height/2-e.clientY+r.top);draw();},{passive:false});
canvas.addEventListener('keydown',e=>{const a={ArrowLeft:[.1,0],ArrowRight:[-.1,0],ArrowUp:[0,-.1],ArrowDown:[0,.1]}[e.key];
  if(a){state.turn+=a[0];state.tilt=Math.max(-1.5707,Math.min(1.5707,state.tilt+a[1]));}
  else if(e.key==='+'||e.key==='=')zoom(1.15,0,0);else if(e.key==='-')zoom(1/1.15,0,0);else return;
  e.preventDefault();draw();});
function move(dx,dy){const k=pixelsPerMm();state.pan[0]+=dx/k;state.pan[1]-=dy/k;}
// The point under (x, y), in pixels from the middle, stays where it is.
function zoom(f,x,y){const k=pixelsPerMm(),before=state.zoom;state.zoom=Math.max(.2,Math.min(200,state.zoom*f));const g=state.zoom/before;
  state.pan[0]+=x/k*(1/g-1);state.pan[1]+=y/k*(1/g-1);}

// Controls.
const press=(group,on)=>document.querySelectorAll('[data-'+group+']').forEach(b=>b.setAttribute('aria-pressed',String(b.dataset[group]===on)));
const refresh=()=>{buildCut();draw();};
document.querySelectorAll('[data-mode]').forEach(b=>b.onclick=()=>{state.mode=b.dataset.mode;press('mode',state.mode);$('cut-tools').hidden=state.mode==='surface';refresh();});
document.querySelectorAll('[data-axis]').forEach(b=>b.onclick=()=>{state.axis=+b.dataset.axis;state.facing=camera()[2];faceMe();press('axis',b.dataset.axis);refresh();});
document.querySelectorAll('[data-look]').forEach(b=>b.onclick=()=>{[state.turn,state.tilt]=b.dataset.look.split(',').map(Number);state.pan=[0,0];state.zoom=1;draw();});
$('place').oninput=e=>{state.place=+e.target.value;refresh();};
$('flip').onclick=()=>{state.flip=!state.flip;refresh();};
$('color').onchange=e=>{state.color=e.target.value;$('ramp').hidden=state.color!=='quality';refresh();};
$('edges').onchange=e=>{state.edges=e.target.checked;draw();};
$('contour-lines').onchange=e=>{state.contours=e.target.checked;draw();};
document.querySelectorAll('[data-structure]').forEach(b=>b.onchange=()=>{shown[+b.dataset.structure]=b.checked;buildSurface();buildContours();refresh();});
canvas.addEventListener('webglcontextlost',e=>{e.preventDefault();say('The 3D view was stopped by the browser. Load the page again to bring it back.');});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change',()=>{readColors();buildContours();draw();});
new ResizeObserver(draw).observe(stage);
// The page's address may say what to show first: #mode=section&axis=1&place=0.4&edges=1&contours=1
new URLSearchParams(location.hash.slice(1)).forEach((v,k)=>{
  const b=document.querySelector('[data-'+CSS.escape(k)+'="'+CSS.escape(v)+'"]');
  if(k==='mode'&&b){state.mode=v;press(k,v);$('cut-tools').hidden=v==='surface';}
  else if(k==='axis'&&b&&v!=='3'){state.axis=+v;press(k,v);}
  else if(k==='place'&&v>=0&&v<=1){state.place=+v;$('place').value=v;}
  else if(k==='edges'){state.edges=$('edges').checked=v==='1';}
  else if(k==='contours'){state.contours=$('contour-lines').checked=v==='1';}
  else if(k==='color'&&v==='quality'){state.color=$('color').value=v;$('ramp').hidden=false;}
  else if(k==='turn'&&isFinite(v))state.turn=+v;else if(k==='tilt'&&isFinite(v))state.tilt=+v;
});
faceMe();readColors();buildSurface();buildContours();buildCut();paint();
})();
)js";

}  // namespace anatomesh
